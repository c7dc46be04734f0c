"""Describes what the camera shows now."""

from dataclasses import dataclass
from enum import StrEnum


class Seen(StrEnum):
    """What is seen of the remote site."""

    LIVE = "live"
    LATE = "late"
    """Pictures arrive and are too old."""
    FROZEN = "frozen"
    """No picture has arrived for too long."""
    NO_CAMERA = "no_camera"
    """The camera's process has no camera."""
    SILENT = "silent"
    """The camera's process does not answer."""
    REFUSED = "refused"
    """The camera's process refuses this side's key."""


@dataclass(frozen=True, slots=True)
class CameraNow:
    """State of the picture.

    Attributes:
        seen: what is seen.
        age_s: time since the newest picture was captured, s; before the first one, since the start.
        reduced: whether the picture gives way to touch.
        required: whether the session pauses without a live picture.
    """

    seen: Seen
    age_s: float
    reduced: bool = False
    required: bool = False

    @property
    def holds(self) -> bool:
        """Whether the session must not run now, because its picture is required and not live."""
        return self.required and self.seen is not Seen.LIVE
