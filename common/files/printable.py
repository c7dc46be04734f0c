"""Makes text from other sources printable on one line of a terminal or a log."""

LONGEST = 2000
"""Maximum number of characters that are shown; the message then states the full length."""


def printable(text: str, longest: int = LONGEST) -> str:
    """Return `text` on one line, with each character that is not printable escaped.

    Control characters, text direction overrides and lone surrogates appear as `\\x1b` or `\\u202e`.

    Args:
        text: any text.
        longest: maximum number of characters; a longer text is cut and its length is stated.
    """
    shown = text[:longest]
    if not shown.isprintable():
        shown = "".join(one if one.isprintable() else _escaped(one) for one in shown)
    if len(text) <= longest and len(shown) <= longest:
        return shown
    return f"{shown[:longest]}... ({len(text)} characters)"


def one_line(text: str, longest: int) -> str:
    """Return the first `longest` characters of `text`, with a space for each one that is not printable."""
    return "".join(one if one.isprintable() else " " for one in text[:longest])


def printable_lines(text: str) -> str:
    """Return `text` with its lines kept and each line as `printable` shows it."""
    return "\n".join(printable(line) for line in text.split("\n"))


def _escaped(one: str) -> str:
    return one.encode("unicode_escape").decode("ascii")
