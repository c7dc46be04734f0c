"""Version of the installed program."""

from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def software_version() -> str:
    """Return the installed version, or "unknown: not installed"."""
    try:
        return version("teletaction")
    except PackageNotFoundError:
        return "unknown: not installed"
