"""Texts of clinical documents: printable, bounded and whole."""

from datetime import UTC, datetime
from pathlib import Path

import pytest

from operator_site.console.examination.examination import LONGEST_NOTE
from teletaction.export.clinical_findings import ClinicalExamination, plain_text
from teletaction.export.named_recording import NamedRecording
from tests.unit.teletaction.recorded_examination import NOTES, record_findings


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


def test_withdrawn_findings_are_left_out_and_counted_and_a_place_on_the_body_is_a_text(tmp_path: Path) -> None:
    body = {"region": "palm", "side": "left", "landmark": "", "landmark_mm": None}
    path = record_findings(tmp_path / "session.mcap", [{"body": body}, {"withdrawn": "an edge"}, {"body": {"side": 3}}])
    with path.open("rb") as file:
        examination = ClinicalExamination(NamedRecording(path, file, datetime(2026, 11, 28, tzinfo=UTC)))
    assert [finding.number for finding in examination.findings] == [1, 3]
    assert [finding.details.get("place on body") for finding in examination.findings] == ["left palm", None]
    assert examination.conclusion == "2 findings marked by the operator; not signed. 1 finding withdrawn and left out."
