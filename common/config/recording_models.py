"""The patient's consent, and how a process records."""

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
