"""Which version of this program runs."""

from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def software_version() -> str:
    """As it was installed; says so where it was not."""
    try:
        return version("teletaction")
    except PackageNotFoundError:
        return "unknown: not installed"
