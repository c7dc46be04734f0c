"""Reads the camera's messages: compares the clocks, dates each picture, and prepares the packets to the camera."""

import math

from common.limits import FROZEN_S
from common.link.stream_clock import StreamClock
from common.wire.camera_messages import ASK_S, CameraAsk, CameraState, read_picture
from common.wire.packets import BadPacket
from operator_site.console.camera.camera_now import CameraNow, Seen
from operator_site.console.camera.camera_picture import Picture, follows

SILENT_S = 1.0
"""Longest silence of a camera's process that answers, s."""
KEY_S = 1.0
"""Shortest interval between two requests for a key picture, s."""
_LARGEST_US = 600_000_000


class PictureReader:
    """Reads one camera. Pure: time is an argument, ns of this machine's monotonic clock.

    Attributes:
        damaged: number of unreadable messages, which are dropped.
        clock: comparison with the camera's clock.
    """

    def __init__(self, now_ns: int, *, required: bool = False):
        self.damaged = 0
        self.clock = StreamClock()
        self._required = required
        self._heard_ns = self._arrived_ns = self._captured_ns = now_ns
        self._state = CameraState.SHOWING
        self._newest = 0
        self._decodable: int | None = None
        """Sequence of the newest picture that can be decoded; None until the next key picture."""
        self._age_ns = 0
        self._asked_ns = self._key_ns = -(10**18)
        self._news = False
        self._touch_age_s = 0.0

    def take(self, parts: list[bytes], now_ns: int) -> Picture | None:
        """Take one message; return its picture if it has one that can be decoded."""
        try:
            header, content = read_picture(parts)
            if header.time_ns > header.sent_ns:  # a picture of the future would count as live until then
                raise BadPacket("camera: sent before it was captured")
            self.clock.compare(header.asked_ns, header.heard_ns, header.sent_ns, now_ns, self._asked_ns)
        except ValueError:  # BadPacket, and times that cannot be
            self.damaged += 1
            return None
        self._heard_ns, self._state = now_ns, header.state
        if not content or (dating := self.clock.dating) is None:
            return None
        offset_ns, uncertainty_ns = dating
        captured_ns = header.time_ns - offset_ns
        picture = Picture(
            header.sequence,
            captured_ns * 1e-9,
            uncertainty_ns * 1e-9,
            header.is_key,
            header.width,
            header.height,
            content,
        )
        self._newest, self._news = header.sequence, True
        self._age_ns = max(0, now_ns - captured_ns)
        self._decodable = picture.sequence if follows(picture, self._decodable) else None
        if self._decodable is None:
            return None
        self._arrived_ns, self._captured_ns = now_ns, captured_ns
        return picture

    def ask(self, now_ns: int, session: int, touch_age_s: float, *, wants_key: bool) -> CameraAsk | None:
        """Return the packet to send now, or None; one is due after each picture and after ASK_S.

        Args:
            now_ns: time, ns.
            session: number of the operator's session; 0 without one.
            touch_age_s: present age of touch, s; 0 where it is unknown.
            wants_key: whether a page waits for a key picture.
        """
        if math.isfinite(touch_age_s):
            self._touch_age_s = max(self._touch_age_s, touch_age_s)
        if not self._news and now_ns - self._asked_ns < ASK_S * 1e9:
            return None
        wants = (wants_key or self._decodable is None) and now_ns - self._key_ns >= KEY_S * 1e9
        if wants:
            self._key_ns = now_ns
        age_us = min(round(self._touch_age_s * 1e6), _LARGEST_US)
        self._asked_ns, self._news, self._touch_age_s = now_ns, False, 0.0
        return CameraAsk(session, self._newest, now_ns, age_us, min(self._age_ns // 1000, _LARGEST_US), wants)

    def silent_s(self, now_ns: int) -> float:
        """Return the time since the newest message, s; before the first, since the start."""
        return (now_ns - self._heard_ns) * 1e-9

    def now(self, now_ns: int, *, refused: bool = False) -> CameraNow:
        """Return what is seen.

        Args:
            now_ns: time, ns.
            refused: whether the camera's process refuses this side's key.
        """
        age_s = max(0.0, (now_ns - self._captured_ns) * 1e-9)
        if refused:
            seen = Seen.REFUSED
        elif self.silent_s(now_ns) > SILENT_S:
            seen = Seen.SILENT
        elif self._state is CameraState.NO_CAMERA:
            seen = Seen.NO_CAMERA
        elif age_s <= FROZEN_S:
            seen = Seen.LIVE
        else:
            seen = Seen.LATE if (now_ns - self._arrived_ns) * 1e-9 <= FROZEN_S else Seen.FROZEN
        return CameraNow(seen, age_s, self._state is CameraState.GIVES_WAY, self._required)
