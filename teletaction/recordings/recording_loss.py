"""Describes what the recording of one process lacks, by the last status of the process."""

from collections.abc import Mapping
from typing import Any


def recording_loss(status: Mapping[str, Any]) -> str:
    """Return why a recording is incomplete and how many messages were lost; empty for a complete one."""
    why, lost = status.get("recording_failed"), status.get("recording_lost", 0)
    if not why and not lost:
        return ""
    return f"recording incomplete: {why or 'the disk was slower than the data'}, {lost} messages lost"
