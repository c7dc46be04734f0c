"""Texts of clinical documents: printable, bounded and whole."""

import pytest

from operator_site.console.examination.examination import LONGEST_NOTE
from teletaction.export.clinical_findings import plain_text
from tests.unit.teletaction.recorded_examination import NOTES


@pytest.mark.parametrize("note", NOTES.values(), ids=NOTES)
def test_a_text_is_printable_with_its_lines(note: str) -> None:
    text = plain_text(note)
    assert text.replace("\n", "").isprintable()
    assert text == text.strip()
    assert text.count("\n") == note.strip(" \n\t").count("\n")


def test_the_longest_note_of_the_console_is_whole() -> None:
    assert plain_text("x" * LONGEST_NOTE) == "x" * LONGEST_NOTE
    worst = plain_text("\U000f0000" * LONGEST_NOTE)
    assert worst == "\\U000f0000" * LONGEST_NOTE


def test_printable_text_of_every_script_stays_as_it_is() -> None:
    text = "Größe 5 µm, עברית, عربي, 日本語, 🖐🏽\nsecond line"
    assert plain_text(text) == text
