"""Simulate a second sender on a CAN bus: it answers each frame of a site with its own under the same identifier."""

from collections.abc import Mapping

from common.buses.can_frames import SentFrame, frame_crc, packing

AHEAD = 8
"""Offset of the intruder's frame counter from the site's; with it, no node refuses its frames as repeated."""


class Intruder:
    """Override a site's commands while active.

    Attributes:
        active: whether the intruder sends.
    """

    def __init__(self, frames: Mapping[str, Mapping[str, float]]) -> None:
        """Set the values that the intruder commands, by frame and signal name, mm or N."""
        self.active = False
        self._own = {packing(name).frame_id: (packing(name), dict(values)) for name, values in frames.items()}

    def answer(self, frame_id: int, data: bytes) -> list[SentFrame]:
        """Return the frames that immediately follow a frame of the site."""
        if not self.active or frame_id not in self._own or len(data) != 8:
            return []
        layout, values = self._own[frame_id]
        _, counter = layout.unpack(data)
        sent = layout.pack(values, (counter + AHEAD) & 0xF)
        sent = sent[:7] + bytes((frame_crc(frame_id, sent),))
        return [(frame_id, sent)]
