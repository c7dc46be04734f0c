"""Findings as FHIR: values with unit and uncertainty, the pseudonym, hostile notes, no findings and many."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from teletaction.export.clinical_findings import plain_text
from teletaction.export.export import export
from teletaction.report.examination import Examination
from tests.unit.teletaction.recorded_examination import (
    NOTES,
    record,
    record_empty,
    record_findings,
    record_many,
    record_notes,
)


def exported(recording: Path, out: Path, body_site: str | None = None) -> dict[str, list[dict[str, Any]]]:
    """Resources of the bundle by type."""
    counts = export(recording, "fhir", out, body_site=body_site)
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


@pytest.mark.long
def test_a_finding_has_its_values_with_unit_and_uncertainty(tmp_path: Path) -> None:
    recording = record(tmp_path / "session.mcap")
    examination = Examination.read(recording)
    found = exported(recording, tmp_path / "out")
    (report,) = found["DiagnosticReport"]
    assert report["subject"]["identifier"]["value"] == examination.begun["pseudonym"]
    assert report["status"] == "preliminary"
    assert report["conclusion"] == (
        "2 findings marked by the operator; not signed. 1 message of the recording could not be read."
    )
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
        texts = {
            part["code"]["text"]: part["valueString"] for part in observation["component"] if "valueString" in part
        }
        assert texts == {"finger": "index", "comparison": finding["compare"], "material": "<i>skin_dermis</i>"} | {
            "sides of the map": "top: head, right: left"
        }
    assert placed


def test_hostile_notes_are_plain_text(tmp_path: Path) -> None:
    found = exported(record_notes(tmp_path / "session.mcap"), tmp_path / "out")
    notes = [each.get("note", [{"text": ""}])[0]["text"] for each in found["Observation"]]
    assert notes == [plain_text(note) for note in NOTES.values()]
    assert all(note.replace("\n", "").isprintable() for note in notes)


@pytest.mark.long
def test_the_same_recording_gives_the_same_bundle(tmp_path: Path) -> None:
    recording = record(tmp_path / "session.mcap")
    exported(recording, tmp_path / "a")
    exported(recording, tmp_path / "b")
    assert (tmp_path / "a" / "findings.fhir.json").read_bytes() == (tmp_path / "b" / "findings.fhir.json").read_bytes()


@pytest.mark.long
def test_a_session_without_an_examination_has_an_empty_report(tmp_path: Path) -> None:
    found = exported(record_empty(tmp_path / "session.mcap"), tmp_path / "out")
    (report,) = found["DiagnosticReport"]
    assert "subject" not in report
    assert "result" not in report, "FHIR has no empty lists"
    assert found["Observation"] == []
    assert report["conclusion"] == "0 findings marked by the operator; not signed."


def test_five_hundred_findings_are_all_there(tmp_path: Path) -> None:
    found = exported(record_many(tmp_path / "many.mcap"), tmp_path / "out")
    assert [each["valueString"] for each in found["Observation"]] == [f"stiff {number}" for number in range(1, 501)]
    assert len({each["id"] for each in found["Observation"]}) == 500


@pytest.mark.long
def test_every_observation_names_the_body_site(tmp_path: Path) -> None:
    recording = record(tmp_path / "session.mcap")
    found = exported(recording, tmp_path / "coded", body_site="SCT:80248007:left breast")
    coded = {"coding": [{"system": "http://snomed.info/sct", "code": "80248007"}], "text": "left breast"}
    assert [each["bodySite"] for each in found["Observation"]] == [coded, coded]
    found = exported(recording, tmp_path / "text", body_site="left breast")
    assert [each["bodySite"] for each in found["Observation"]] == [{"text": "left breast"}] * 2


def test_the_registration_of_the_console_is_the_body_site_unless_the_command_names_one(tmp_path: Path) -> None:
    examined = {"region": "forearm", "side": "left", "landmark": "wrist crease", "landmark_mm": 20.0}
    palm = {"region": "palm", "side": "left", "landmark": "", "landmark_mm": None}
    sides = {"top": "head", "right": "left"}
    recording = record_findings(tmp_path / "s.mcap", [{}, {"body": palm}], body=examined, sides=sides)
    found = exported(recording, tmp_path / "out")["Observation"]
    assert [each["bodySite"] for each in found] == [{"text": "left forearm"}, {"text": "left palm"}]
    for observation in found:
        texts = {part["code"]["text"]: part.get("valueString") for part in observation["component"]}
        assert texts["examined part"] == "left forearm, 20 mm from wrist crease"
        assert texts["sides of the map"] == "top: head, right: left"
    named = exported(recording, tmp_path / "named", body_site="left arm")["Observation"]
    assert [each["bodySite"] for each in named] == [{"text": "left arm"}] * 2
    unknown = exported(record_findings(tmp_path / "unknown.mcap", [{}], sides=None), tmp_path / "none")["Observation"]
    assert "bodySite" not in unknown[0]


def test_an_impossible_time_is_one_clear_error(tmp_path: Path) -> None:
    recording = record_findings(tmp_path / "session.mcap", [{"at_s": 1e300}])
    with pytest.raises(ValueError, match=r"has an impossible time, 1e\+300 s"):
        export(recording, "fhir", tmp_path / "out")


@pytest.mark.exports
@pytest.mark.parametrize("site", [None, "left breast", "SCT:80248007:left breast"])
@pytest.mark.parametrize("recorded", [record, record_empty, record_notes, record_many])
def test_the_bundle_is_valid(recorded: Callable[[Path], Path], site: str | None, tmp_path: Path) -> None:
    """The validator of another project accepts the bundle, and gives the same values back."""
    from fhir.resources.R4B.bundle import Bundle

    export(recorded(tmp_path / "session.mcap"), "fhir", tmp_path / "out", body_site=site)
    written = (tmp_path / "out" / "findings.fhir.json").read_text("utf-8")
    read = Bundle.model_validate_json(written).model_dump_json().replace('000Z"', 'Z"')  # it writes microseconds
    assert json.loads(read) == json.loads(written)
