"""Writes the findings of an examination as FHIR R4: a Bundle with a DiagnosticReport and one Observation a finding.

The subject is the pseudonym of the session. A value carries its UCUM unit and its standard uncertainty (extensions
iso21090-uncertainty and iso21090-uncertaintyType of HL7).
"""

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from uuid import UUID, uuid5

from common.files.printable import printable_lines
from common.files.private_file import create_private
from teletaction.export.named_recording import NamedRecording
from teletaction.report.examination import Examination

Resource = dict[str, Any]
UCUM = {"temperature": "Cel", "roughness": "V", "stiffness": "N/m"}
"""UCUM code of each quantity of the tactile map."""
_UNITS = {"Cel": "°C", "mm": "mm"}
_SYSTEM = "http://unitsofmeasure.org"
_EXTENSION = "http://hl7.org/fhir/StructureDefinition/iso21090-"
_PSEUDONYMS = "urn:teletaction:pseudonym"
_NAMES = UUID("5f0cf1f2-7f4e-4c52-9d7c-6c1a6c0d1a55")
"""Name space of the resources' identifiers. The same recording gives the same identifiers."""
_LONGEST_TEXT = 10_000
_REPORT = "Tactile examination by telemanipulation"


def write_fhir(recording: NamedRecording, out: Path) -> dict[str, int]:
    """Write `findings.fhir.json` into `out`. All resources are preliminary: nobody has signed them.

    Returns:
        Number of resources of each type.

    Raises:
        OSError: the file cannot be written.
        ValueError: the recording is damaged.
    """
    examination = Examination.read(recording.path)
    writer = _Resources(recording, examination)
    observations = [writer.observation(finding) for finding in examination.findings.values()]
    resources = [writer.report(observations), *observations]
    bundle = {
        "resourceType": "Bundle",
        "type": "collection",
        "timestamp": writer.time(None),
        "entry": [{"fullUrl": f"urn:uuid:{each['id']}", "resource": each} for each in resources],
    }
    with create_private(out / "findings.fhir.json", replace=True) as file:
        file.write(json.dumps(bundle, ensure_ascii=False, indent=1, allow_nan=False).encode() + b"\n")
    return {"DiagnosticReport": 1, "Observation": len(observations)}


class _Resources:
    """Makes the resources of one examination."""

    def __init__(self, recording: NamedRecording, examination: Examination):
        self._recording, self._examination = recording, examination
        pseudonym = examination.begun.get("pseudonym")
        subject = {"identifier": {"system": _PSEUDONYMS, "value": _text(pseudonym)}}
        self._subject = {"subject": subject} if pseudonym else {}

    def time(self, at_s: float | None) -> str:
        """Return a wall-clock time for a time of the recording, s; that of its first message for None."""
        recording = self._recording
        wall_ns = recording.begin_ns if at_s is None else recording.anchor.wall_time_ns(round(at_s * 1e9))
        return datetime.fromtimestamp(wall_ns * 1e-9, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")

    def report(self, observations: list[Resource]) -> Resource:
        """Return the report on all observations."""
        begun_s, ended_s = self._examination.begun.get("at_s"), self._examination.ended_s
        period = {"start": self.time(begun_s)} | ({"end": self.time(ended_s)} if ended_s is not None else {})
        count = len(observations)
        return {
            "resourceType": "DiagnosticReport",
            "id": self._id("report"),
            "status": "preliminary",
            "code": {"text": _REPORT},
            **self._subject,
            "effectivePeriod": period,
            **({"result": [{"reference": f"urn:uuid:{each['id']}"} for each in observations]} if observations else {}),
            "conclusion": f"{count} finding{'' if count == 1 else 's'} marked by the operator; not signed.",
        }

    def observation(self, finding: Mapping[str, Any]) -> Resource:
        """Return the observation of one finding: its values, its place, and the operator's note."""
        kind, note = finding.get("kind"), _text(finding.get("note") or "")
        components = self._components(finding)
        return {
            "resourceType": "Observation",
            "id": self._id(f"finding {finding['id']}"),
            "status": "preliminary",
            "code": {"text": _text(kind or "finding")},
            **self._subject,
            "effectiveDateTime": self.time(finding["at_s"]),
            "valueString": _text(finding["text"]) or "-",
            **({"component": components} if components else {}),
            **({"note": [{"text": note}]} if note else {}),
        }

    def _components(self, finding: Mapping[str, Any]) -> list[Resource]:
        x_m, y_m = finding.get("x_m"), finding.get("y_m")
        if x_m is None or y_m is None:
            return []
        here = self._examination.felt.at(float(x_m), float(y_m))
        places = {"x on the remote bench": x_m, "y on the remote bench": y_m}
        found = [_component(name, _quantity(1e3 * float(at_m), "mm")) for name, at_m in places.items()]
        for name, code in UCUM.items():
            if (value := getattr(here, name)) is not None:
                found.append(_component(name, _quantity(value.value, code, value.sd)))
        if here.material is not None:
            found.append({"code": {"text": "material"}, "valueString": _text(here.material[0])})
        return found

    def _id(self, name: str) -> str:
        return str(uuid5(_NAMES, f"{self._recording.begin_ns} {self._examination.begun.get('pseudonym')} {name}"))


def _component(name: str, quantity: Resource) -> Resource:
    return {"code": {"text": name}, "valueQuantity": quantity}


def _quantity(value: float, code: str, sd: float | None = None) -> Resource:
    """Return a quantity with its standard deviation, both with at most six significant digits."""
    quantity = {"value": _decimal(value), "unit": _UNITS.get(code, code), "system": _SYSTEM, "code": code}
    if sd is None:
        return quantity
    uncertainty = [
        {"url": f"{_EXTENSION}uncertainty", "valueDecimal": _decimal(sd)},
        {"url": f"{_EXTENSION}uncertaintyType", "valueCode": "N"},
    ]
    return {"extension": uncertainty, **quantity}


def _decimal(value: float) -> float:
    return float(f"{value:.6g}")


def _text(value: object) -> str:
    """Return printable text of bounded length without blanks around it, as FHIR demands of a string."""
    return printable_lines(str(value))[:_LONGEST_TEXT].strip()
