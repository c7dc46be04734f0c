"""Reads the remote site's recording, motion and patient from the answer to a status request."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from common.files.printable import one_line
from common.tenderness.pain_report import MOST_REPORTS, PainReport
from common.tenderness.presses import WORST_PAIN
from common.wire.packets import BadPacket
from common.wire.session_messages import LONGEST_REFUSAL

_COLUMNS = len(PainReport._fields)


class RemotePatient(NamedTuple):
    """What the remote site reports of its patient.

    Attributes:
        pain: answer of the pain slider, 0..10; None while it is unknown.
        limit_n: force limit that follows the patient, N; None while the default limit holds.
        reports: the newest reports of pain, oldest first.
        agreed: whether the patient agrees to have pain recorded.
    """

    pain: float | None
    limit_n: float | None
    reports: tuple[PainReport, ...]
    agreed: bool = False


def recording_stopped(details: Mapping[str, object]) -> str:
    """Return why the remote site's recording stopped, in one printable line; empty while it works or if unreported.

    Raises:
        BadPacket: the reason is no text.
    """
    return _line("recording", details)


def late_motion(details: Mapping[str, object]) -> str:
    """Return since when no motion arrives at the engaged remote site, in one line; empty while it does.

    Raises:
        BadPacket: it is no text.
    """
    return _line("stale", details)


def remote_patient(details: Mapping[str, object]) -> RemotePatient | None:
    """Return what is reported of the patient; None from a site without a pain slider.

    Raises:
        BadPacket: a value is no number or beyond its range, or a report is not complete.
    """
    if "pain" not in details:
        return None
    listed = details.get("pain_reports", [])
    if not isinstance(listed, list) or len(listed) % _COLUMNS or len(listed) > MOST_REPORTS * _COLUMNS:
        raise BadPacket("pain_reports is no list of whole reports")
    numbers = [_number("pain_reports", value, math.inf) for value in listed]
    rows = [numbers[at : at + _COLUMNS] for at in range(0, len(numbers), _COLUMNS)]
    pain, limit_n = details["pain"], details.get("patient_limit_n")
    return RemotePatient(
        None if pain is None else _number("pain", pain, WORST_PAIN, 0.0),
        None if limit_n is None else _number("patient_limit_n", limit_n, math.inf, 0.0),
        tuple(PainReport(*row) for row in rows),
        details.get("pain_agreed") is True,
    )


def patient_details(patient: RemotePatient | None, time_ns: int) -> dict[str, object]:
    """Return the details from which `remote_patient` reads the same patient, and the time of the report, ns."""
    if patient is None:
        return {}
    return {
        "pain": patient.pain,
        "patient_limit_n": patient.limit_n,
        "pain_reports": [value for report in patient.reports for value in report],
        "pain_agreed": patient.agreed,
        "pain_ns": time_ns,
    }


def _line(name: str, details: Mapping[str, object]) -> str:
    said = details.get(name, "")
    if not isinstance(said, str):
        raise BadPacket(f"{name} is no text")
    return one_line(said, LONGEST_REFUSAL).strip() or ("the remote site does not say why" if said else "")


def _number(name: str, value: object, high: float, low: float = -math.inf) -> float:
    if not isinstance(value, float) or not low <= value <= high:
        raise BadPacket(f"{name} is no number in its range")
    return value
