"""The recorded row of what the patient reports; the remote site writes it, the console and the report read it."""

from common.recording.recorded_row import Row
from common.tenderness.presses import WORST_PAIN


class Patient(Row):
    """What the patient reports, where there is a pain slider and consent; recorded on each change."""

    pain: float | None
    """Answer, 0..10; null while it is unknown."""
    limit_n: float | None
    """Force limit that follows the patient's threshold, N; null while the default limit holds."""


def read_patient(payload: bytes) -> Patient:
    """Read a recorded row; raises ValueError where it is none, or a value is beyond its range."""
    row = Patient.unpack(payload)
    if row.pain is not None and not 0.0 <= row.pain <= WORST_PAIN:
        raise ValueError(f"pain {row.pain} is not within 0..{WORST_PAIN:g}")
    if row.limit_n is not None and not 0.0 <= row.limit_n < float("inf"):
        raise ValueError(f"limit_n {row.limit_n} is no force")
    return row
