"""The operator site's loop: read the hand, render what the remote site touches, pass the gate, write."""

import logging
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import msgpack
import numpy as np

from common.acceptance import Acceptance
from common.capabilities import capabilities
from common.config import OperatorConfig, to_toml
from common.desk import Desk
from common.fingers import FINGERS
from common.keys import fingerprint, load_keys
from common.limits import FINGER_FORCE_N, MOTOR_FLOOR_RPM, MOTOR_MAX_RPM, PLATE_PROFILES
from common.link import LinkProblem, OperatorLink
from common.messages import Event, Touch
from common.packets import Floats, LinkState
from common.recording import PACKET_SCHEMA, SESSION_SCHEMA, Recorder, recording_figures
from common.session import Refused, note_text
from common.site_loop import run_site_loop
from common.startup import wait_for_devices
from common.streams import STREAMS
from operator_site import rendering_input
from operator_site.devices import OperatorDevices
from operator_site.exoskeleton import Hand
from operator_site.gate import GatedOutput, limit_names
from operator_site.remote_key import remote_public_key
from operator_site.rendering import Rendering
from operator_site.rendering_input import RenderingInput
from operator_site.session_client import SessionClient

log = logging.getLogger(__name__)

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
    "operator/clock": {"type": "array", "description": "[offset_ns, uncertainty_ns, round_trip_ns] to the remote site"},
}
_SLOW_EVERY = 25
"""Ticks between two records of what changes slowly: 20 Hz."""
_HAND_AGE_S = 0.020
"""An older pose of the hand is not sent: the remote site notices the gap and stops."""


class OperatorSite:
    """One tick at a time; everything that computes is pure and in its own file."""

    def __init__(
        self,
        config: OperatorConfig,
        link: OperatorLink,
        devices: OperatorDevices,
        recorder: Recorder | None = None,
        desk: Desk | None = None,
        stamp_ns: Callable[[], int] | None = None,
    ):
        self._devices = devices
        self._recorder = recorder
        self._desk = desk
        self.rendering = Rendering(config.rendering, config.link.gap_s)
        plates = PLATE_PROFILES[config.rendering.profile]
        able = capabilities(
            config.fingers,
            config.rate_hz,
            force_n=FINGER_FORCE_N,
            motor_rpm=[MOTOR_FLOOR_RPM, MOTOR_MAX_RPM],
            plate_c=[plates.low_c, plates.high_c],
            max_age_s=config.link.max_age_s,
        )
        self.client = SessionClient(
            link,
            able,
            config.link.max_age_s,
            config.engage,
            config.link.calibration or "",
            gap_s=config.link.gap_s,
            stamp_ns=stamp_ns,
        )
        self._now_ns = 0
        self._ticks = 0
        self._limited: list[int] = []
        self._recorded_touch: Touch | None = None
        self.motions_sent = 0

    def tick(self, now_ns: int) -> None:
        """Read, render, gate, write, tell."""
        now_s = now_ns * 1e-9
        hand = self._devices.read(now_s)
        client = self.client
        self._now_ns = now_ns
        if self._desk is not None:
            self._desk.serve(now_ns, self._ask)
        missing = self._devices.missing()
        client.session.equipped(missing)
        client.step(now_ns, self.rendering.fault or missing, self._devices.unconfirmed)
        motion = self._send_motion(now_ns, now_s, hand)
        given = self._rendering_input(now_ns, now_s, hand)
        output = self.rendering.step(given)
        self._limited = output.limited
        if output.fault is not None:
            client.session.latch(output.fault)
        self._devices.write(now_s, output, client.both_engaged)
        happenings = client.session.take_happenings()
        if self._recorder is not None:
            for happening in happenings:
                self._recorder.write("operator/session", now_ns, happening.pack())
            self._record(self._recorder, now_ns, given, output, motion)
        self._ticks += 1

    def figures(self) -> dict[str, object]:
        """What the status file tells."""
        client = self.client
        acceptance: Acceptance = client.acceptance
        return {
            "state": client.session.state.name.lower(),
            "fault": client.session.fault,
            "remote_fault": client.remote_fault,
            "estop": client.stopped,
            "refusal": client.refusal,
            "missing": self._devices.missing(),
            "devices": self._devices.figures(),
            "limited": {FINGERS[finger]: limit_names(bits) for finger, bits in enumerate(self._limited) if bits},
            "age_ms": round(acceptance.age_ns * 1e-6, 3),
            "max_age_ms": round(acceptance.max_age_ns * 1e-6, 3),
            "clock": {
                "offset_ns": client.clock.offset_ns,
                "uncertainty_ns": client.clock.uncertainty_ns,
                "steps": client.clock.steps,
            },
            "sent": {"motion": self.motions_sent},
            "received": {"touch": acceptance.received},
            "superseded": {"touch": acceptance.lost},
            "refused": {"touch": dict(acceptance.refused), "damaged": dict(client.damaged)},
            **recording_figures(self._recorder),
        }

    def goodbye(self) -> None:
        """Leave the session, so that nobody has to wait for the silence."""
        self.client.goodbye(self._now_ns)

    def _not_ready(self) -> str:
        return self.rendering.fault or self._devices.missing()

    def _ask(self, verb: str, details: dict[str, Any]) -> dict[str, Any]:
        """What the person at the operator's desk may ask for."""
        client = self.client
        session = client.session
        match verb:
            case "status":
                pass
            case "engage":
                if session.state is LinkState.FAULT or client.remote_fault:
                    raise Refused(f"a fault is latched ({session.fault or client.remote_fault}): clear it first")
                client.want_engaged = True
            case "disengage":
                client.disengage(self._now_ns)
            case "estop":
                client.stop(self._now_ns, "emergency stop by the operator")
            case "clear_fault":
                client.clear(self._now_ns)
            case "annotate":
                if not session.ident:
                    raise Refused("there is no session to note anything in")
                client.request(verb, self._now_ns, {"text": note_text(details)})
            case _:
                raise Refused(f"{verb} is not for the desk to ask")
        if verb != "status":
            log.info("desk: %s, now %s", verb, session.state.name.lower())
        return {
            "state": session.state.name.lower(),
            "fault": session.fault,
            "remote_fault": client.remote_fault,
            "refusal": client.refusal,
            "missing": self._not_ready(),
            "estop": client.stopped,
        }

    def _rendering_input(self, now_ns: int, now_s: float, hand: Hand) -> RenderingInput:
        client = self.client
        plate_c, plate_age_s = self._devices.plates(now_s)
        return RenderingInput(
            now_s,
            client.session.ident,
            # The session was cleared by a person, and the gate with it.
            self.rendering.fault is not None and client.session.state is not LinkState.FAULT,
            client.both_engaged,
            client.acceptance.gap_ns(now_ns) if client.touch is not None else None,
            client.touch,
            hand.x_m,
            hand.y_m,
            hand.z_m,
            hand.pose_s,
            hand.heights_s,
            tuple(plate_c),
            tuple(plate_age_s),
            tuple(self._devices.faults()),
        )

    def _send_motion(self, now_ns: int, now_s: float, hand: Hand) -> bytes | None:
        if now_s - hand.oldest_s > _HAND_AGE_S:
            return None
        block: Floats = np.array([(hand.x_m, hand.y_m, z_m) for z_m in hand.z_m], dtype=np.float32)
        packet = self.client.send_motion(now_ns, block)
        self.motions_sent += packet is not None
        return packet

    def _record(
        self, recorder: Recorder, now_ns: int, given: RenderingInput, output: GatedOutput, motion: bytes | None
    ) -> None:
        client = self.client
        touch, gap_ns = given.touch, given.gap_ns
        if touch is not None and touch is not self._recorded_touch:
            recorder.write("operator/touch", now_ns, client.touch_packet)
            self._recorded_touch = touch
        recorder.write("operator/input", now_ns, given.pack())
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
        recorder.write("operator/rendered", now_ns, msgpack.packb(rendered))
        if motion is not None and STREAMS["motion"].recorded:
            recorder.write("operator/motion", now_ns, motion)
        fingertips = self.rendering.fingertips
        if fingertips.impulses_played and touch is not None:
            by_ident: dict[int, Event] = {event.ident: event for event in touch.events}
            for ident in fingertips.impulses_played:
                event = by_ident[ident]
                recorder.write("operator/played", now_ns, msgpack.packb([ident, int(event.kind), event.finger]))
        if self._ticks % _SLOW_EVERY == 0:
            skin = fingertips.skin
            slow = [skin.epidermis_c.tolist(), skin.surface_c.tolist(), skin.flux_w_m2.tolist()]
            recorder.write("operator/skin", now_ns, msgpack.packb(slow))
            clock = client.clock
            recorder.write(
                "operator/clock", now_ns, msgpack.packb([clock.offset_ns, clock.uncertainty_ns, clock.round_trip_ns])
            )


class Admission:
    """Whether the remote site lets this one in: its refusal ends a site that was never let in, and no other."""

    def __init__(self, site: OperatorSite, link: OperatorLink, remote: str):
        self._site, self._link = site, link
        self._problem = (
            f"{remote}: the remote site does not trust this site's key as an operator's; "
            "there: `teletaction keys trust --keys FOLDER -- NAME KEY`"
        )
        self._welcome = self._said = False

    def each_second(self) -> None:
        """Look at what became of the handshakes.

        Raises:
            LinkProblem: the remote site does not trust this site's key.
        """
        client = self._site.client
        connected = client.session.ident != 0
        self._welcome = self._welcome or connected
        if not self._link.key_refused():
            if connected and self._said:
                self._said, client.refusal = False, ""
            return
        if not self._welcome:
            raise LinkProblem(self._problem)
        # It was revoked while we worked. The library does not try again after a refusal, so we do.
        if not self._said:
            self._said, client.refusal = True, self._problem
            log.warning("%s", self._problem)
        self._link.reconnect()


def run_operator(config: OperatorConfig, stop: Callable[[], bool]) -> None:
    """Run the operator site until `stop()`.

    Raises:
        ValueError, OSError: keys or devices cannot be used, or the remote site refuses this site's key.
    """
    keys = load_keys(config.link.keys)
    remote_key = remote_public_key(config.link)
    with ExitStack() as opened:
        desk = opened.enter_context(Desk(config.desk_port, keys))
        devices = OperatorDevices(config)
        opened.callback(devices.close)
        if not wait_for_devices(devices, config.wait_for_devices_s, stop):
            return
        link = opened.enter_context(OperatorLink(config.link.host, config.link.base_port, keys, remote_key))
        remote = f"{config.link.host}:{config.link.base_port}"
        log.info("connecting to %s as %s", remote, fingerprint(keys.public))
        recorder = None
        if config.record is not None:
            metadata = {"configuration": to_toml(config), "key": fingerprint(keys.public)}
            recorder = opened.enter_context(Recorder(config.record, SCHEMAS, metadata))
        site = OperatorSite(config, link, devices, recorder, desk, time.monotonic_ns)
        admission = Admission(site, link, remote)
        run_site_loop(site, "operator", config.rate_hz, stop, status=config.status, each_second=admission.each_second)
        site.goodbye()
