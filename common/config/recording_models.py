"""The patient's consent, and how a process records."""

from common.config.section import Section


class ConsentConfig(Section):
    """What the patient agrees to have recorded, asked before the session."""

    touch: bool
    pain: bool
    picture: bool = False
    voice: bool = False


class RecordingConfig(Section):
    """How a process records."""

    encrypt: bool = False
    """Whether the recording is encrypted for the owner of the site's secret key."""
