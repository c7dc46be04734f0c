"""Text from elsewhere as one line that a terminal or a log shows and does not obey."""

LONGEST = 2000
"""Characters of a text that are shown; the rest is counted."""


def printable(text: str, longest: int = LONGEST) -> str:
    """`text` on one line: control characters, text direction overrides and lone surrogates stand as `\\x1b`, `\\u202e`.

    Args:
        text: anything.
        longest: what is longer is cut, and its length is said.
    """
    shown = text[:longest]
    if not shown.isprintable():
        shown = "".join(one if one.isprintable() else _escaped(one) for one in shown)
    if len(text) <= longest and len(shown) <= longest:
        return shown
    return f"{shown[:longest]}... ({len(text)} characters)"


def one_line(text: str, longest: int) -> str:
    """The first `longest` characters of `text`, with a space for each one that is not printable."""
    return "".join(one if one.isprintable() else " " for one in text[:longest])


def printable_lines(text: str) -> str:
    """`text` with its lines kept, each as `printable` shows it."""
    return "\n".join(printable(line) for line in text.split("\n"))


def _escaped(one: str) -> str:
    return one.encode("unicode_escape").decode("ascii")
