"""The form of requests and answers in the record of acts and in the log."""

from typing import Any

from common.files.printable import one_line

LONGEST_KEPT = 200
"""Maximum length of a detail in the record of acts, characters; the finding holds the full note."""


def whole(value: object) -> object:
    """Replace unpaired surrogates in a text, which no file and no socket accepts; return other values unchanged."""
    return value.encode("utf-16", "surrogatepass").decode("utf-16", "replace") if isinstance(value, str) else value


def shown(text: object, longest: int = 40) -> str:
    """Return a text for record and log: one line of printable characters."""
    return one_line(str(text), longest)


def recorded(details: dict[Any, Any]) -> dict[str, object]:
    """Return details for the record: at most 20, each short."""
    return {str(name)[:40]: _plain(value) for name, value in list(details.items())[:20]}


def _plain(value: object) -> object:
    """Return a detail for the record."""
    if value is None or isinstance(value, (bool, float)) or (isinstance(value, int) and abs(value) < 2**63):
        return value
    if isinstance(value, str):
        return value[:LONGEST_KEPT]
    try:
        return str(whole(str(value)[:LONGEST_KEPT]))
    except (RecursionError, ValueError):  # nested too deeply, or an integer with too many digits
        return f"a {type(value).__name__}"
