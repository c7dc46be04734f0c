"""Version of the installed program, and the commit that it was installed from."""

import json
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution, version


@cache
def software_version() -> str:
    """Return the installed version, or "unknown: not installed"."""
    try:
        return version("teletaction")
    except PackageNotFoundError:
        return "unknown: not installed"


def source_commit() -> str:
    """Return the commit that pip installed the program from; empty where it came from a wheel or a folder."""
    try:
        text = distribution("teletaction").read_text("direct_url.json")
        return str(json.loads(text or "{}").get("vcs_info", {}).get("commit_id", ""))
    except (PackageNotFoundError, ValueError, AttributeError):
        return ""
