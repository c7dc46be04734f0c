"""Reads the body site of an examination: a text, or a SNOMED CT code with its text."""

import re
from typing import NamedTuple, Self

from common.files.printable import printable

LONGEST = 64
"""Maximum length of a body site's text, characters; DICOM allows no more."""
_CODED = re.compile(r"SCT:(\d{6,18}):([^:]+)")


class BodySite(NamedTuple):
    """A part of the body: its text, and its SNOMED CT code, empty if unknown."""

    text: str
    code: str = ""

    @classmethod
    def parse(cls, written: str) -> Self:
        """Read `left breast`, or with a code `SCT:80248007:left breast`.

        Raises:
            ValueError: it is written otherwise, or its text is empty, too long or not printable.
        """
        coded = _CODED.fullmatch(written.strip())
        code, text = (coded[1], coded[2].strip()) if coded else ("", written.strip())
        if not 0 < len(text) <= LONGEST or not text.isprintable() or {":", "\\"} & set(text):
            raise ValueError(
                f"body site '{printable(written, 2 * LONGEST)}': write 'left breast' or 'SCT:80248007:left breast', "
                f"with a text of at most {LONGEST} printable characters without colon and backslash"
            )
        return cls(text, code)
