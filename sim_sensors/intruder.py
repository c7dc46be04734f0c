"""A second sender on a CAN bus: it answers each frame of a site with one of its own under the same identifier."""

from collections.abc import Mapping

import can

from common.can_frames import frame_crc, packing

AHEAD = 8
"""Its counters are this far from the site's, so that no node takes its frames for repeated ones."""


class Intruder:
    """Overrides a site's commands while it is active.

    Attributes:
        active: whether it sends.
    """

    def __init__(self, frames: Mapping[str, Mapping[str, float]]) -> None:
        """`frames`: what it commands, values by frame name, mm, N."""
        self.active = False
        self._own = {packing(name).frame_id: (packing(name), dict(values)) for name, values in frames.items()}

    def answer(self, frame_id: int, data: bytes) -> list[can.Message]:
        """The frames that follow one of a site at once."""
        if not self.active or frame_id not in self._own or len(data) != 8:
            return []
        layout, values = self._own[frame_id]
        _, counter = layout.unpack(data)
        sent = layout.pack(values, (counter + AHEAD) & 0xF)
        sent = sent[:7] + bytes((frame_crc(frame_id, sent),))
        return [can.Message(arbitration_id=frame_id, data=sent, is_extended_id=False)]
