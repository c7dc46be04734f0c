"""Writes the findings of an examination as FHIR R4: a Bundle with a DiagnosticReport and one Observation a finding.

The subject is the pseudonym of the session. A value carries its UCUM unit and its standard uncertainty (extensions
iso21090-uncertainty and iso21090-uncertaintyType of HL7).
"""

import json
from datetime import datetime
from pathlib import Path
from typing import Any

from common.files.private_file import write_private
from teletaction.export.body_site import BodySite
from teletaction.export.clinical_findings import PSEUDONYMS, UNIT_TEXT, ClinicalExamination, ClinicalFinding, Quantity
from teletaction.export.named_recording import NamedRecording

Resource = dict[str, Any]
_UCUM = "http://unitsofmeasure.org"
_SNOMED_CT = "http://snomed.info/sct"
_EXTENSION = "http://hl7.org/fhir/StructureDefinition/iso21090-"
REPORT = "Tactile examination by telemanipulation"
"""Text of the report's code, by which a document is recognised as one of this program."""


def write_fhir(recording: NamedRecording, out: Path, body_site: BodySite | None = None) -> dict[str, int]:
    """Write `findings.fhir.json` into `out`. All resources are preliminary: nobody has signed them."""
    writer = _Resources(ClinicalExamination(recording), body_site)
    observations = [writer.observation(finding) for finding in writer.examination.findings]
    resources = [writer.report(observations), *observations]
    bundle = {
        "resourceType": "Bundle",
        "type": "collection",
        "timestamp": _time(writer.examination.recorded[0]),
        "entry": [{"fullUrl": f"urn:uuid:{each['id']}", "resource": each} for each in resources],
    }
    content = json.dumps(bundle, ensure_ascii=False, indent=1, allow_nan=False).encode() + b"\n"
    write_private(out / "findings.fhir.json", content)
    return {"DiagnosticReport": 1, "Observation": len(observations)}


class _Resources:
    """Makes the resources of one examination."""

    def __init__(self, examination: ClinicalExamination, body_site: BodySite | None):
        self.examination = examination
        subject = {"identifier": {"system": PSEUDONYMS, "value": examination.pseudonym}}
        self._subject = {"subject": subject} if examination.pseudonym else {}
        self._body_site = body_site

    def report(self, observations: list[Resource]) -> Resource:
        """Return the report on all observations."""
        begun, ended = self.examination.begun, self.examination.ended
        return {
            "resourceType": "DiagnosticReport",
            "id": str(self.examination.identifier("report")),
            "status": "preliminary",
            "code": {"text": REPORT},
            **self._subject,
            "effectivePeriod": {"start": _time(begun)} | ({"end": _time(ended)} if ended is not None else {}),
            **({"result": [{"reference": f"urn:uuid:{each['id']}"} for each in observations]} if observations else {}),
            "conclusion": self.examination.conclusion,
        }

    def observation(self, finding: ClinicalFinding) -> Resource:
        """Return the observation of one finding: its values, its place, and the operator's note."""
        components = [_component(quantity) for quantity in finding.quantities]
        components += [{"code": {"text": name}, "valueString": text} for name, text in finding.details.items()]
        site = self._body_site or (BodySite(finding.site) if finding.site else None)
        return {
            "resourceType": "Observation",
            "id": str(self.examination.identifier(f"finding {finding.number}")),
            "status": "preliminary",
            "code": {"text": finding.kind or "finding"},
            **self._subject,
            "effectiveDateTime": _time(finding.at),
            "valueString": finding.text or "-",
            **({} if site is None else {"bodySite": _site(site)}),
            **({"component": components} if components else {}),
            **({"note": [{"text": finding.note}]} if finding.note else {}),
        }


def _component(quantity: Quantity) -> Resource:
    """Return a value with its standard deviation, both with at most six significant digits."""
    unit = {"unit": UNIT_TEXT.get(quantity.unit, quantity.unit), "system": _UCUM, "code": quantity.unit}
    value = {"value": _decimal(quantity.value), **unit}
    if quantity.sd is not None:
        value["extension"] = [
            {"url": f"{_EXTENSION}uncertainty", "valueDecimal": _decimal(quantity.sd)},
            {"url": f"{_EXTENSION}uncertaintyType", "valueCode": "N"},
        ]
    return {"code": {"text": quantity.name}, "valueQuantity": value}


def _site(site: BodySite) -> Resource:
    return ({"coding": [{"system": _SNOMED_CT, "code": site.code}]} if site.code else {}) | {"text": site.text}


def _decimal(value: float) -> float:
    return float(f"{value:.6g}")


def _time(at: datetime) -> str:
    return at.isoformat(timespec="milliseconds").replace("+00:00", "Z")
