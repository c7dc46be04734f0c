"""Records the exact input and output of each tick at the operator site, and slowly changing values at 20 Hz.

Consoles receive some of the same streams, and each record is packed once for both.
"""

import time
from collections.abc import Iterable, Mapping

import msgpack

from common.link.session_state import Happening
from common.recording.recorder import PACKET_SCHEMA, Recorder
from common.wire.messages import Touch
from common.wire.streams import STREAMS
from operator_site.coupling.coupling import DIRECT, Coupling
from operator_site.fingertips import Fingertips
from operator_site.recorded_rows import Clock, Played, Rendered, RenderingInput, Skin
from operator_site.safety.gated_output import GatedOutput
from operator_site.session.console_feed import ConsoleFeed
from operator_site.session.session_protocol import SessionProtocol

SCHEMAS: dict[str, dict[str, object]] = {
    "operator/session": Happening.schema(),
    "operator/motion": PACKET_SCHEMA,
    "operator/touch": PACKET_SCHEMA,
    "operator/coupling": Coupling.schema(),
    "operator/input": RenderingInput.schema(),
    "operator/rendered": Rendered.schema(),
    "operator/skin": Skin.schema(),
    "operator/played": Played.schema(),
    "operator/figures": {"type": "object", "description": "values of the status file, once a second"},
    "operator/clock": Clock.schema(),
}
_MOTION_RECORDED = STREAMS["motion"].recorded
_SLOW_EVERY = 25
"""Ticks between two records of slowly changing values: 20 Hz at 500 ticks a second."""


class SiteRecording:
    """Writes the records of each tick to a recorder and to consoles."""

    def __init__(self, recorder: Recorder | None, feed: ConsoleFeed | None = None):
        """Write to a recorder that was opened with SCHEMAS, to consoles, or to both."""
        self._recorder = recorder
        self._feed = feed
        self._ticks = 0
        self._touch: Touch | None = None
        self._coupling = DIRECT

    def session(self, now_ns: int, happenings: Iterable[Happening]) -> None:
        """Write the events of the session."""
        for happening in happenings:
            self._write("operator/session", now_ns, happening.pack())

    def figures(self, now_ns: int, figures: Mapping[str, object]) -> None:
        """Write the values of the status file."""
        self._write("operator/figures", now_ns, msgpack.packb(figures))

    def tick(
        self,
        now_ns: int,
        client: SessionProtocol,
        given: RenderingInput,
        output: GatedOutput,
        motion: bytes | None,
        fingertips: Fingertips,
        coupling: Coupling,
    ) -> None:
        """Write one completed tick.

        Args:
            now_ns: begin of the tick on this site's clock, ns.
            client: this site's end of the session.
            given: input of the renderer.
            output: output to the devices.
            motion: sent motion packet; None without one.
            fingertips: the renderer after the tick.
            coupling: coupling of the hand in this tick; a new one is recorded before the input.
        """
        touch, gap_ns = client.touch, given.gap_ns
        if touch is not None and touch is not self._touch:
            self._write("operator/touch", now_ns, client.touch_packet)
            self._touch = touch
        if coupling is not self._coupling:
            self._write("operator/coupling", now_ns, coupling.pack())
            self._coupling = coupling
        if self._recorder is not None:
            self._recorder.write("operator/input", now_ns, given.pack())
            if motion is not None and _MOTION_RECORDED:
                self._recorder.write("operator/motion", now_ns, motion)
        rendered = Rendered(
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
            given.touch,
            time.monotonic(),
        )
        self._write("operator/rendered", now_ns, rendered.pack())
        for event in fingertips.impulses_played:
            self._write("operator/played", now_ns, Played(event.ident, event.kind, event.finger).pack())
        if self._ticks % _SLOW_EVERY == 0:
            skin = fingertips.skin
            slow = Skin(skin.epidermis_c, skin.surface_c, skin.flux_w_m2)
            self._write("operator/skin", now_ns, slow.pack())
            clock = Clock(client.clock.offset_ns, client.clock.uncertainty_ns, client.clock.round_trip_ns)
            self._write("operator/clock", now_ns, clock.pack())
        self._ticks += 1

    def _write(self, stream: str, now_ns: int, payload: bytes) -> None:
        if self._recorder is not None:
            self._recorder.write(stream, now_ns, payload)
        if self._feed is not None:
            self._feed.write(stream, now_ns, payload)
