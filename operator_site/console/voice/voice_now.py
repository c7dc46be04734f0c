"""Describes what is heard now, at both ends."""

from dataclasses import dataclass
from enum import StrEnum


class Heard(StrEnum):
    """What is heard of the remote site."""

    LIVE = "live"
    MUTED = "muted"
    """The remote microphone is muted."""
    NO_MICROPHONE = "no_microphone"
    """The voice's process has no microphone."""
    SILENT = "silent"
    """The voice's process does not answer."""
    REFUSED = "refused"
    """The voice's process refuses this side's key."""


@dataclass(frozen=True, slots=True)
class VoiceNow:
    """State of the voice.

    Attributes:
        heard: what is heard of the remote site.
        hears: whether the remote site plays what is said here.
        recorded: whether the sound of both sides is recorded.
        talker: name of the page that talks; empty without one.
    """

    heard: Heard
    hears: bool = False
    recorded: bool = False
    talker: str = ""
