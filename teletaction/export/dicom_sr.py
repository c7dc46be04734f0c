"""Writes the findings of an examination as DICOM: a Comprehensive SR after template TID 1500, one group a finding.

Names without a standard code have codes of the scheme 99TELETACTION. Values are doubles (FloatingPointValue), so none
is rounded.
"""

from datetime import datetime
from pathlib import Path

from highdicom import UID, SOPClass
from highdicom.coding_schemes import CodingSchemeIdentificationItem
from highdicom.sr import (
    CodeContentItem,
    ContainerContentItem,
    ContentSequence,
    DeviceObserverIdentifyingAttributes,
    FindingSite,
    Measurement,
    MeasurementProperties,
    MeasurementsAndQualitativeEvaluations,
    NumContentItem,
    ObserverContext,
    RelationshipTypeValues,
    TextContentItem,
    TrackingIdentifier,
)
from pydicom.sr.codedict import codes
from pydicom.sr.coding import Code
from pydicom.uid import ComprehensiveSRStorage, ExplicitVRLittleEndian

from common.files.printable import printable
from common.files.private_file import create_private, replacing
from common.version import software_version
from operator_site.console.examination.findings import KINDS
from teletaction.export.body_site import BodySite
from teletaction.export.clinical_findings import PSEUDONYMS, UNIT_TEXT, ClinicalExamination, ClinicalFinding, Quantity
from teletaction.export.named_recording import NamedRecording

SCHEME = "99TELETACTION"
"""Coding scheme of the names that have no standard code."""
_CODE_VALUES = {"x on the remote bench": "x", "y on the remote bench": "y", "share of material": "material share"}
"""Code values of the names that are longer than the 16 characters of a code value."""
_QUALITATIVE = Code("C0034375", "UMLS", "Qualitative Evaluations")
_SPREAD = "An uncertainty is one standard deviation."
_LONGEST_ID = 64
"""Maximum length of a patient's identifier in DICOM, characters."""
_CONTAINS = RelationshipTypeValues.CONTAINS


def write_dicom_sr(recording: NamedRecording, out: Path, body_site: BodySite | None = None) -> dict[str, int]:
    """Write `findings.dcm` into `out`: preliminary and unverified, because nobody has signed it.

    Raises:
        ValueError: DICOM does not allow the subject's pseudonym.
    """
    examination = ClinicalExamination(recording)
    pseudonym = examination.pseudonym
    if len(pseudonym) > _LONGEST_ID or {"\\", "\n"} & set(pseudonym):
        raise ValueError(
            f"{recording.path}: DICOM does not allow the pseudonym '{printable(pseudonym, _LONGEST_ID)}': more than "
            f"{_LONGEST_ID} characters, a backslash or a line break; export it as fhir"
        )
    document = _document(examination, f"findings {body_site} {software_version()}")
    document.update(_report(examination, body_site))
    with replacing(out / "findings.dcm") as made, create_private(made, replace=True) as file:
        document.save_as(file, enforce_file_format=True)
    return {"findings": len(examination.findings)}


def _document(examination: ClinicalExamination, name: str) -> SOPClass:
    """Return the document's header. Other content needs another `name`, since a UID stands for one content."""
    end = examination.recorded[1]
    document = SOPClass(
        study_instance_uid=_uid(examination, "study"),
        series_instance_uid=_uid(examination, "series"),
        series_number=1,
        sop_instance_uid=_uid(examination, name),
        sop_class_uid=ComprehensiveSRStorage,
        instance_number=1,
        modality="SR",
        manufacturer="teletaction",
        software_versions=software_version(),
        transfer_syntax_uid=ExplicitVRLittleEndian,
        specific_character_set="ISO_IR 192",
        coding_schemes=[CodingSchemeIdentificationItem(SCHEME, name="teletaction")],
        patient_id=examination.pseudonym,
        study_id=f"{examination.begun:%Y%m%d%H%M%S}",
        study_date=examination.begun.date(),
        study_time=examination.begun.time(),
        content_date=end.date(),
        content_time=end.time(),
    )
    document.TimezoneOffsetFromUTC = "+0000"
    if examination.pseudonym:
        document.IssuerOfPatientID = PSEUDONYMS
    document.CompletionFlag = "PARTIAL" if examination.ended is None else "COMPLETE"
    document.VerificationFlag = "UNVERIFIED"
    document.PreliminaryFlag = "PRELIMINARY"
    document.PerformedProcedureCodeSequence = []
    document.ReferencedPerformedProcedureStepSequence = []
    # The time of this export would make every file of a recording another one.
    del document.InstanceCreationDate, document.InstanceCreationTime
    return document


def _report(examination: ClinicalExamination, body_site: BodySite | None) -> ContainerContentItem:
    """Return the root of the content: observer, procedure, one group a finding, and the conclusion.

    highdicom's own class for this template allows no report without a finding.
    """
    root = ContainerContentItem(codes.DCM.ImagingMeasurementReport, template_id="1500")
    device = DeviceObserverIdentifyingAttributes(
        _uid(examination, "device"), name="teletaction", model_name=", ".join(examination.versions) or None
    )
    root.ContentSequence = ContentSequence(
        [
            *ObserverContext(codes.DCM.Device, device),
            CodeContentItem(codes.DCM.ProcedureReported, codes.SCT.Palpation, RelationshipTypeValues.HAS_CONCEPT_MOD),
        ]
    )
    if examination.findings:
        groups = ContainerContentItem(codes.DCM.ImagingMeasurements, relationship_type=_CONTAINS)
        groups.ContentSequence = ContentSequence(
            [_group(examination, finding, body_site) for finding in examination.findings]
        )
        root.ContentSequence.append(groups)
    conclusion = ContainerContentItem(_QUALITATIVE, relationship_type=_CONTAINS)
    conclusion.ContentSequence = ContentSequence(
        [TextContentItem(codes.DCM.Comment, f"{examination.conclusion} {_SPREAD}", _CONTAINS)]
    )
    root.ContentSequence.append(conclusion)
    return root


def _group(
    examination: ClinicalExamination, finding: ClinicalFinding, body_site: BodySite | None
) -> ContainerContentItem:
    """Return the measurement group (TID 1501) of one finding."""
    name = f"finding {finding.number}"
    known_kind = finding.kind in KINDS
    (group,) = MeasurementsAndQualitativeEvaluations(
        TrackingIdentifier(_uid(examination, name), name),
        finding_category=codes.SCT.FindingByPalpation,
        finding_type=_own(finding.kind) if known_kind else None,
        measurements=[_measurement(quantity) for quantity in finding.quantities],
    )
    group.ObservationDateTime = _date_time(finding.at)
    if site := body_site or (BodySite(finding.site) if finding.site else None):
        group.ContentSequence.append(_site(site))
    texts = {
        _own("kind"): "" if known_kind else finding.kind,
        _own("description"): finding.text,
        **{_own(detail): text for detail, text in finding.details.items()},
        codes.DCM.Comment: finding.note,
    }
    group.ContentSequence.extend([TextContentItem(code, text, _CONTAINS) for code, text in texts.items() if text])
    return group


def _measurement(quantity: Quantity) -> Measurement:
    """Return a measured value (TID 300) with its standard deviation as upper and lower uncertainty (TID 310)."""
    unit = Code(quantity.unit, "UCUM", UNIT_TEXT.get(quantity.unit, quantity.unit))
    properties = MeasurementProperties()
    if quantity.sd is not None:
        # highdicom's own arguments for them write no unit.
        properties.extend(
            NumContentItem(side, quantity.sd, unit, relationship_type=RelationshipTypeValues.HAS_PROPERTIES)
            for side in (codes.SCT.RangeOfUpperMeasurementUncertainty, codes.SCT.RangeOfLowerMeasurementUncertainty)
        )
    return Measurement(_own(quantity.name), quantity.value, unit, properties=properties)


def _site(site: BodySite) -> FindingSite | TextContentItem:
    if site.code:
        return FindingSite(Code(site.code, "SCT", site.text))
    return TextContentItem(codes.SCT.FindingSite, site.text, RelationshipTypeValues.HAS_CONCEPT_MOD)


def _own(name: str) -> Code:
    """Return the code of a name in our scheme."""
    return Code(_CODE_VALUES.get(name, name), SCHEME, name)


def _uid(examination: ClinicalExamination, name: str) -> UID:
    return UID.from_uuid(str(examination.identifier(name)))


def _date_time(at: datetime) -> str:
    return f"{at:%Y%m%d%H%M%S.%f%z}"
