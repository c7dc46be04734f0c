"""The word list finds its words in pages, in code and in other files."""

from pathlib import Path

import pytest

from tests.docs.words import found, listed

WORDS = listed("# a comment\ntell, told: send\ngo on: continue\n^Whether: the verb\n")


@pytest.mark.parametrize(
    ("name", "text", "lines"),
    [
        ("a.md", "# Title\n\nThe device\ntold it to go\non.\n", ["3: told: send", "3: go on: continue"]),
        ("a.md", "# Whether it works\n", ["1: Whether: the verb"]),
        ("a.md", "# Title\n\nWhether `told` or not: [a page](told.md), retold.\n", []),
        ("a.py", '"""Whether it works."""\n\ntold = 1  # told\n', ["1: Whether: the verb", "3: told: send"]),
        ("a.js", "// it was\n// told\n", ["2: told: send"]),
        ("a.py", '"""A module."""\n\n\ndef works() -> bool:\n    """Whether it works."""\n', []),
    ],
)
def test_listed_words_are_found_in_prose(name: str, text: str, lines: list[str], tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(text, "utf-8")
    assert [line.removeprefix(f"{path}:") for line in found([path], WORDS)] == lines
