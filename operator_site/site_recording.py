"""What the operator site records: each tick's exact input and output, and at 20 Hz what changes slowly.

Consoles see some of the same: what both want is packed once.
"""

import time
from collections.abc import Iterable, Mapping

import msgpack

from common.messages import Touch
from common.recording import PACKET_SCHEMA, SESSION_SCHEMA, Recorder
from common.session import Happening
from common.streams import STREAMS
from operator_site import rendering_input
from operator_site.feed import ConsoleFeed
from operator_site.fingertips import Fingertips
from operator_site.gated_output import GatedOutput
from operator_site.operator_session import OperatorSession
from operator_site.rendering_input import RenderingInput

SCHEMAS: dict[str, dict[str, object]] = {
    "operator/session": SESSION_SCHEMA,
    "operator/motion": PACKET_SCHEMA,
    "operator/touch": PACKET_SCHEMA,
    "operator/input": rendering_input.SCHEMA,
    "operator/rendered": {
        "type": "array",
        "description": "[engaged, touch age_s, force_n x 5, motor_rpm x 5, plate_set_c x 5, peltier x 5, limits x 5, "
        "fault or null, x_m, y_m, z_m x 5, plate_c x 5, touch sequence, written_s]: what left for the devices when, "
        "and its input",
    },
    "operator/skin": {"type": "array", "description": "[felt_c x 5, surface_c x 5, flux_w_m2 x 5] of the skin model"},
    "operator/played": {"type": "array", "description": "[event id, kind, finger]: impulse begun"},
    "operator/figures": {"type": "object", "description": "what the status file tells, once a second"},
    "operator/clock": {"type": "array", "description": "[offset_ns, uncertainty_ns, round_trip_ns] to the remote site"},
}
_pack = msgpack.Packer().pack
_MOTION_RECORDED = STREAMS["motion"].recorded
_SLOW_EVERY = 25
"""Ticks between two records of what changes slowly: 20 Hz."""


class SiteRecording:
    """Writes one tick after the other."""

    def __init__(self, recorder: Recorder | None, feed: ConsoleFeed | None = None):
        """Write to a recorder that was opened with SCHEMAS, to consoles, or to both."""
        self._recorder = recorder
        self._feed = feed
        self._ticks = 0
        self._touch: Touch | None = None

    def session(self, now_ns: int, happenings: Iterable[Happening]) -> None:
        """Write what happened to the session."""
        for happening in happenings:
            self._write("operator/session", now_ns, happening.pack())

    def figures(self, now_ns: int, figures: Mapping[str, object]) -> None:
        """Write what the status file tells."""
        self._write("operator/figures", now_ns, _pack(figures))

    def tick(
        self,
        now_ns: int,
        client: OperatorSession,
        given: RenderingInput,
        output: GatedOutput,
        motion: bytes | None,
        fingertips: Fingertips,
    ) -> None:
        """Write one tick that has just been done.

        Args:
            now_ns: when it began, this site's clock.
            client: this site's end of the session.
            given: what was rendered from.
            output: what left for the devices.
            motion: the packet that was sent; None when none was.
            fingertips: the renderer, as the tick left it.
        """
        touch, gap_ns = given.touch, given.gap_ns
        if touch is not None and touch is not self._touch:
            self._write("operator/touch", now_ns, client.touch_packet)
            self._touch = touch
        if self._recorder is not None:
            self._recorder.write("operator/input", now_ns, given.pack())
            if motion is not None and _MOTION_RECORDED:
                self._recorder.write("operator/motion", now_ns, motion)
        rendered = [
            client.both_engaged,
            None if gap_ns is None else gap_ns * 1e-9,
            output.force_n,
            output.motor_rpm,
            output.plate_set_c,
            output.peltier_drive,
            output.limited,
            output.fault,
            given.x_m,
            given.y_m,
            given.z_m,
            given.plate_c,
            None if touch is None else touch.sequence,
            time.monotonic(),
        ]
        self._write("operator/rendered", now_ns, _pack(rendered))
        for event in fingertips.impulses_played:
            self._write("operator/played", now_ns, _pack([event.ident, int(event.kind), event.finger]))
        if self._ticks % _SLOW_EVERY == 0:
            skin = fingertips.skin
            slow = [skin.epidermis_c.tolist(), skin.surface_c.tolist(), skin.flux_w_m2.tolist()]
            self._write("operator/skin", now_ns, _pack(slow))
            clock = client.clock
            compared = [clock.offset_ns, clock.uncertainty_ns, clock.round_trip_ns]
            self._write("operator/clock", now_ns, _pack(compared))
        self._ticks += 1

    def _write(self, stream: str, now_ns: int, payload: bytes) -> None:
        if self._recorder is not None:
            self._recorder.write(stream, now_ns, payload)
        if self._feed is not None:
            self._feed.write(stream, now_ns, payload)
