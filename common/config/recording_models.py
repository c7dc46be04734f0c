"""The patient's consent, and how a process records."""

from pathlib import Path

from common.files.strict_model import StrictModel


class ConsentConfig(StrictModel):
    """What the patient agrees to have recorded, asked before the session."""

    touch: bool
    pain: bool
    picture: bool = False
    voice: bool = False


class RecordingConfig(StrictModel):
    """How a process records."""

    encrypt: bool = False
    """Whether the recording is encrypted for the owner of the site's secret key."""


def require_own_file(record: Path | None, status: Path | None) -> None:
    """Check that the status file does not replace the recording; raises ValueError where both are one file."""
    if record is not None and record == status:
        raise ValueError("record and status name the same file")
