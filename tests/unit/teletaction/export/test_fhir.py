"""Findings as FHIR: values with unit and uncertainty, the pseudonym, hostile notes, no findings and many."""

import json
from pathlib import Path
from typing import Any

import msgpack
import pytest

from common.recording.recorder import Recorder
from teletaction.export.export import export
from teletaction.report.examination import Examination
from tests.unit.teletaction.recorded_examination import HOSTILE, record


def exported(recording: Path, out: Path) -> dict[str, list[dict[str, Any]]]:
    """Resources of the bundle by type."""
    counts = export(recording, "fhir", out)
    bundle = json.loads((out / "findings.fhir.json").read_text("utf-8"))
    assert (bundle["resourceType"], bundle["type"]) == ("Bundle", "collection")
    found: dict[str, list[dict[str, Any]]] = {"DiagnosticReport": [], "Observation": []}
    for entry in bundle["entry"]:
        assert entry["fullUrl"] == f"urn:uuid:{entry['resource']['id']}"
        found[entry["resource"]["resourceType"]].append(entry["resource"])
    assert counts == {kind: len(resources) for kind, resources in found.items()}
    return found


def quantities(observation: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {
        part["code"]["text"]: part["valueQuantity"]
        for part in observation.get("component", ())
        if "valueQuantity" in part
    }


def test_a_finding_has_its_values_with_unit_and_uncertainty(tmp_path: Path) -> None:
    recording = record(tmp_path / "session.mcap")
    examination = Examination.read(recording)
    found = exported(recording, tmp_path / "out")
    (report,) = found["DiagnosticReport"]
    assert report["subject"]["identifier"]["value"] == examination.begun["pseudonym"]
    assert report["status"] == "preliminary"
    assert [each["reference"] for each in report["result"]] == [
        f"urn:uuid:{each['id']}" for each in found["Observation"]
    ]
    placed = 0
    for finding, observation in zip(examination.findings.values(), found["Observation"], strict=True):
        values = quantities(observation)
        if finding["x_m"] is None:
            assert values == {}
            continue
        placed += 1
        here = examination.felt.at(finding["x_m"], finding["y_m"])
        assert values["x on the remote bench"] == {
            "value": pytest.approx(1e3 * finding["x_m"]),
            "unit": "mm",
            "system": "http://unitsofmeasure.org",
            "code": "mm",
        }
        assert here.temperature is not None
        temperature = values["temperature"]
        assert (temperature["value"], temperature["code"]) == (pytest.approx(here.temperature.value, rel=1e-5), "Cel")
        stated = {each["url"].rpartition("-")[2]: each for each in temperature["extension"]}
        assert stated["uncertainty"]["valueDecimal"] == pytest.approx(here.temperature.sd, rel=1e-5)
        assert stated["uncertaintyType"]["valueCode"] == "N"
    assert placed


def test_a_hostile_note_is_plain_text_and_bounded(tmp_path: Path) -> None:
    found = exported(record(tmp_path / "session.mcap"), tmp_path / "out")
    notes = [note["text"] for each in found["Observation"] for note in each.get("note", ())]
    assert any(note.startswith("<script>alert(1)</script>") for note in notes)
    assert all(len(note) <= 10_000 and "\u0000" not in note and "\u202e" not in note for note in notes)
    assert HOSTILE not in notes


def test_the_same_recording_gives_the_same_bundle(tmp_path: Path) -> None:
    recording = record(tmp_path / "session.mcap")
    exported(recording, tmp_path / "a")
    exported(recording, tmp_path / "b")
    assert (tmp_path / "a" / "findings.fhir.json").read_bytes() == (tmp_path / "b" / "findings.fhir.json").read_bytes()


def test_a_session_without_an_examination_has_an_empty_report(tmp_path: Path) -> None:
    found = exported(record(tmp_path / "session.mcap", console=False), tmp_path / "out")
    (report,) = found["DiagnosticReport"]
    assert "subject" not in report
    assert "result" not in report, "FHIR has no empty lists"
    assert found["Observation"] == []
    assert report["conclusion"].startswith("0 findings")


def many(path: Path) -> Path:
    """A recording of 500 findings."""
    with Recorder(path, {"console/session": {}, "console/finding": {}}, {}) as recorder:
        begin = {"what": "begin", "at_s": 1.0, "pseudonym": "P-0418", "wall_clock": None, "who": None, "sides": {}}
        recorder.write("console/session", 10**9, msgpack.packb(begin))
        for number in range(500):
            finding = {"id": number, "at_s": 1.0 + number, "kind": "hard", "finger": "index", "text": f"hard {number}"}
            place = {"x_m": 1e-3 * (number % 50), "y_m": 1e-3 * (number // 50), "compare": None, "note": None}
            recorder.write("console/finding", 10**9 * (1 + number), msgpack.packb(finding | place))
    return path


def test_five_hundred_findings_are_all_there(tmp_path: Path) -> None:
    found = exported(many(tmp_path / "many.mcap"), tmp_path / "out")
    assert [each["valueString"] for each in found["Observation"]] == [f"hard {number}" for number in range(500)]
    assert len({each["id"] for each in found["Observation"]}) == 500


@pytest.mark.exports
@pytest.mark.parametrize("case", ["hostile", "empty", "many"])
def test_the_bundle_is_valid(case: str, tmp_path: Path) -> None:
    """The validator of another project accepts the bundle, and gives the same values back."""
    from fhir.resources.R4B.bundle import Bundle

    session = tmp_path / "session.mcap"
    recording = many(session) if case == "many" else record(session, console=case == "hostile")
    export(recording, "fhir", tmp_path / "out")
    written = (tmp_path / "out" / "findings.fhir.json").read_text("utf-8")
    read = Bundle.model_validate_json(written).model_dump_json().replace('000Z"', 'Z"')  # it writes microseconds
    assert json.loads(read) == json.loads(written)
