"""Carries out the requests of pages that play a recording."""

from typing import Any, Protocol

from common.files.constants import within
from common.link.session_state import Refused
from operator_site.console import texts
from operator_site.console.web.answer import Answer
from operator_site.console.web.clients import Client

_LARGEST = 1e9
"""Largest speed and largest time of a request, s."""


class Playing(Protocol):
    """Playback of a recording."""

    def play(self, speed: float) -> None:
        """Play at a multiple of the recorded speed."""

    def pause(self) -> None:
        """Pause the playback."""

    def seek(self, at_s: float) -> bool:
        """Jump to a time, s from the beginning; return False if that part must be read first."""


async def play(player: Playing, client: Client, details: dict[str, Any], now_s: float) -> Answer:
    """Play at a speed."""
    speed = details.get("speed", 1.0)
    if not within(speed, -_LARGEST, _LARGEST):
        raise Refused(texts.SPEED_NEEDED)
    player.play(float(speed))
    return Answer(True, "")


async def pause(player: Playing, client: Client, details: dict[str, Any], now_s: float) -> Answer:
    """Pause."""
    player.pause()
    return Answer(True, texts.PLAYBACK_PAUSED)


async def seek(player: Playing, client: Client, details: dict[str, Any], now_s: float) -> Answer:
    """Jump to a time."""
    at_s = details.get("at_s")
    if not within(at_s, -_LARGEST, _LARGEST):
        raise Refused(texts.TIME_NEEDED)
    return Answer(True, "" if player.seek(max(0.0, float(at_s))) else texts.READING_AHEAD)
