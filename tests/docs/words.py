"""Searches texts for the words of docs/words.txt: `python -m tests.docs.words`, a part of `make check`."""

import re
import sys
import tokenize
from collections.abc import Iterable, Iterator
from pathlib import Path

from tests.docs.pages import tokens
from tests.packaging.requirements import ROOMS
from tests.places import ROOT

SEARCHED = (
    "*.md",
    "deploy/**/*.md",
    "docs/*.md",
    "docs/decisions/*.md",
    "docs/how-it-works/*.md",
    "docs/howto/*.md",
    *(f"{room}/**/*.py" for room in (*ROOMS, "tests")),
    "operator_site/console/page/*",
)
"""Patterns of the files to search: pages, code, tests, and the console's page."""
QUOTING = ("tests/docs/test_words.py", "tests/structure.py")
"""Files that contain the words on purpose."""
_TEXTS = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING)}


def listed(text: str) -> list[tuple[re.Pattern[str], str]]:
    """Return a pattern for each form of a list such as docs/words.txt, and the better words."""
    lines = [line.split(":", 1) for line in text.splitlines() if line and not line.startswith("#")]
    return [(_pattern(form.strip()), instead.strip()) for forms, instead in lines for form in forms.split(",")]


def _pattern(form: str) -> re.Pattern[str]:
    before, word = (r"\^\W*", form[1:]) if form.startswith("^") else (r"\b", form)
    return re.compile(rf"{before}({word})\b", re.IGNORECASE)


def prose(path: Path) -> Iterator[tuple[int, str]]:
    """Yield line and text: a page without its code, comments and strings of a Python file, or all of another file."""
    if path.suffix == ".md":
        for token in tokens(str(path)):
            if token.type == "inline" and token.map:
                yield token.map[0] + 1, "".join(c.content if c.type == "text" else " " for c in token.children or ())
    elif path.suffix == ".py":
        with path.open(encoding="utf-8") as file:
            for part in tokenize.generate_tokens(file.readline):
                if part.type in _TEXTS:
                    yield part.start[0], part.string
    else:
        yield from enumerate(path.read_text("utf-8").splitlines(), 1)


def found(paths: Iterable[Path], words: Iterable[tuple[re.Pattern[str], str]]) -> Iterator[str]:
    """Yield a line for each word found: file, line, the word, and what to write instead."""
    for path in paths:
        for line, text in prose(path):
            for pattern, instead in words:
                if match := pattern.search(f"^{text}" if line == 1 else text):
                    yield f"{path}:{line}: {match[1]}: {instead}"


if __name__ == "__main__":
    files = sorted({path for pattern in SEARCHED for path in ROOT.glob(pattern)} - {ROOT / name for name in QUOTING})
    lines = list(found(files, listed((ROOT / "docs" / "words.txt").read_text("utf-8"))))
    print("\n".join(lines), end="\n" if lines else "")
    sys.exit(bool(lines))
