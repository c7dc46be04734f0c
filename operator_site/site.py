"""The operator site's loop: read the hand, render what the remote site touches, pass the gate, write."""

import logging
import time
from collections.abc import Callable

import msgpack
import numpy as np

from common.acceptance import Acceptance
from common.config import OperatorConfig, to_toml
from common.fingers import FINGERS
from common.keys import KeyProblem, TrustedKeys, check_public_key, fingerprint, load_keys
from common.limits import PLATE_PROFILES
from common.link import LinkProblem, OperatorLink
from common.loop import PeriodicLoop, become_timely
from common.messages import TOUCH_FIELDS, Event
from common.packets import SCHEMA_VERSION, Floats, LinkState
from common.process import StatusFile
from common.recording import PACKET_SCHEMA, Recorder
from common.startup import wait_for_devices
from common.streams import STREAMS
from operator_site.contact_force import ContactLaw
from operator_site.devices import OperatorDevices
from operator_site.exoskeleton import Hand
from operator_site.fingertips import Fingertips
from operator_site.gate import GatedOutput, OperatorGate, limit_names
from operator_site.session_client import SessionClient
from operator_site.skin import Body
from operator_site.stroke_speed import StrokeSpeed

log = logging.getLogger(__name__)

SCHEMAS: dict[str, dict[str, object]] = {
    "operator/motion": PACKET_SCHEMA,
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

    def __init__(self, config: OperatorConfig, link: OperatorLink, devices: OperatorDevices, recorder: Recorder | None):
        rendering = config.rendering
        profile = PLATE_PROFILES[rendering.profile]
        self._devices = devices
        self._recorder = recorder
        self.fingertips = Fingertips(
            profile=profile,
            law=ContactLaw(stiffness_cap_n_m=rendering.max_stiffness_n_m),
            body=Body(deep_c=rendering.deep_c, arterial_c=rendering.deep_c + 1.0, air_c=rendering.air_c),
        )
        self.gate = OperatorGate(profile)
        capabilities = {"schema": SCHEMA_VERSION, "fingers": list(config.fingers), "rate_hz": config.rate_hz}
        self.client = SessionClient(link, capabilities, config.link.max_age_s, config.engage)
        self._speed = StrokeSpeed()
        self._gap_ns = round(config.link.gap_s * 1e9)
        self._session = 0
        self._ticks = 0
        self._limited: list[int] = []
        self.motions_sent = 0

    def tick(self, now_ns: int) -> None:
        """Read, render, gate, write, tell."""
        now_s = now_ns * 1e-9
        hand = self._devices.read(now_s)
        client = self.client
        client.step(now_ns, self.gate.fault or self._devices.missing())
        if self.gate.fault is not None and client.session.state is not LinkState.FAULT:
            self.gate.clear_fault()  # the session was cleared by a person, and the gate with it
        if client.session.ident != self._session:
            self._session = client.session.ident
            self.fingertips.begin_session()
        for finger in self._devices.cut_out():
            self.gate.trip(f"{FINGERS[finger]}: the module's own temperature limit has switched its plate off")
        motion = self._send_motion(now_ns, now_s, hand)
        gap_ns = client.acceptance.gap_ns(now_ns) if client.touch is not None else None
        fresh = gap_ns is not None and gap_ns <= self._gap_ns
        touch = client.touch if fresh else None
        plate_c, plate_age_s = self._devices.plates(now_s)
        requested = self.fingertips.step(
            now_s,
            client.both_engaged and fresh,
            touch=_NEUTRAL if touch is None else touch.block,
            events=() if touch is None else touch.events,
            speed_m_s=self._speed.step(hand.pose_s, hand.x_m, hand.y_m) if hand.oldest_s > 0.0 else 0.0,
            z_m=hand.z_m,
            plate_c=plate_c,
            plate_age_s=plate_age_s,
        )
        output = self.gate.step(
            now_s,
            client.both_engaged,
            gap_ns * 1e-9 if gap_ns is not None else 1e9,
            force_n=requested.force_n,
            motor_rpm=requested.motor_rpm,
            plate_set_c=requested.plate_set_c,
            peltier_drive=requested.peltier_drive,
            plate_measured_c=plate_c,
            measurement_age_s=plate_age_s,
        )
        self._limited = output.limited
        if output.fault is not None:
            client.session.latch(output.fault)
        self._devices.write(now_s, output, client.both_engaged)
        if self._recorder is not None:
            self._record(self._recorder, now_ns, hand, output, motion, plate_c, gap_ns)
        self._ticks += 1

    def figures(self) -> dict[str, object]:
        """What the status file tells."""
        client = self.client
        acceptance: Acceptance = client.acceptance
        return {
            "state": client.session.state.name.lower(),
            "fault": client.session.fault,
            "refusal": client.refusal,
            "missing": self._devices.missing(),
            "devices": self._devices.figures(),
            "limited": {FINGERS[finger]: limit_names(bits) for finger, bits in enumerate(self._limited) if bits},
            "age_ms": round(acceptance.age_ns * 1e-6, 3),
            "clock": {"offset_ns": client.clock.offset_ns, "uncertainty_ns": client.clock.uncertainty_ns},
            "sent": {"motion": self.motions_sent},
            "received": {"touch": acceptance.received},
            "superseded": {"touch": acceptance.lost},
            "refused": {"touch": dict(acceptance.refused), "damaged": dict(client.damaged)},
            "recorded": {} if self._recorder is None else dict(self._recorder.written),
            "recording_lost": 0 if self._recorder is None else self._recorder.lost,
        }

    def _send_motion(self, now_ns: int, now_s: float, hand: Hand) -> bytes | None:
        if now_s - hand.oldest_s > _HAND_AGE_S:
            return None
        block: Floats = np.array([(hand.x_m, hand.y_m, z_m) for z_m in hand.z_m], dtype=np.float32)
        packet = self.client.send_motion(now_ns, block)
        self.motions_sent += packet is not None
        return packet

    def _record(
        self,
        recorder: Recorder,
        now_ns: int,
        hand: Hand,
        output: GatedOutput,
        motion: bytes | None,
        plate_c: list[float],
        gap_ns: int | None,
    ) -> None:
        client = self.client
        touch = client.touch
        rendered = [
            client.both_engaged,
            None if gap_ns is None else gap_ns * 1e-9,
            output.force_n,
            output.motor_rpm,
            output.plate_set_c,
            output.peltier_drive,
            output.limited,
            output.fault,
            hand.x_m,
            hand.y_m,
            hand.z_m,
            plate_c,
            None if touch is None else touch.sequence,
            time.monotonic(),
        ]
        recorder.write("operator/rendered", now_ns, msgpack.packb(rendered))
        if motion is not None and STREAMS["motion"].recorded:
            recorder.write("operator/motion", now_ns, motion)
        if self.fingertips.impulses_played and touch is not None:
            by_ident: dict[int, Event] = {event.ident: event for event in touch.events}
            for ident in self.fingertips.impulses_played:
                event = by_ident[ident]
                recorder.write("operator/played", now_ns, msgpack.packb([ident, int(event.kind), event.finger]))
        if self._ticks % _SLOW_EVERY == 0:
            skin = self.fingertips.skin
            slow = [skin.epidermis_c.tolist(), skin.surface_c.tolist(), skin.flux_w_m2.tolist()]
            recorder.write("operator/skin", now_ns, msgpack.packb(slow))
            clock = client.clock
            recorder.write(
                "operator/clock", now_ns, msgpack.packb([clock.offset_ns, clock.uncertainty_ns, clock.round_trip_ns])
            )


_NEUTRAL: Floats = np.zeros((len(FINGERS), len(TOUCH_FIELDS)), dtype=np.float32)
"""Touching nothing: what is rendered while there is no fresh touch."""


def remote_public_key(config: OperatorConfig) -> str:
    """The remote site's public key: from the configuration, or trusted under the name `remote`.

    Raises:
        KeyProblem: neither says it.
    """
    if config.link.remote_key is not None:
        return check_public_key(config.link.remote_key)
    trusted = TrustedKeys(config.link.keys)
    for key, name in trusted.names().items():
        if name == "remote":
            return key
    raise KeyProblem(
        f"{trusted.file}: no key named `remote`; "
        f"add it with `teletaction keys trust --keys {trusted.folder} -- remote KEY`"
    )


def run_operator(config: OperatorConfig, stop: Callable[[], bool]) -> None:
    """Run the operator site until `stop()`.

    Raises:
        ValueError, OSError: keys or devices cannot be used, or the remote site refuses this site's key.
    """
    keys = load_keys(config.link.keys)
    remote_key = remote_public_key(config)
    devices = OperatorDevices(config)
    try:
        wait_for_devices(devices, config.wait_for_devices_s)
        with OperatorLink(config.link.host, config.link.base_port, keys, remote_key) as link:
            log.info("connecting to %s:%d as %s", config.link.host, config.link.base_port, fingerprint(keys.public))
            metadata = {"configuration": to_toml(config), "key": fingerprint(keys.public)}
            recorder = None if config.record is None else Recorder(config.record, SCHEMAS, metadata)
            try:
                _loop(OperatorSite(config, link, devices, recorder), config, link, stop)
            finally:
                if recorder is not None:
                    recorder.close()
    finally:
        devices.close()


def _loop(site: OperatorSite, config: OperatorConfig, link: OperatorLink, stop: Callable[[], bool]) -> None:
    become_timely()
    loop = PeriodicLoop(1.0 / config.rate_hz)
    status = StatusFile(config.status, "operator", loop)
    refused = False
    while not stop():
        loop.wait()
        site.tick(time.monotonic_ns())
        now_s = time.monotonic()
        if status.due(now_s):
            # A refused socket never tries again, so the refusal is remembered until the session is over.
            refused = link.key_refused() or refused
            if refused and not site.client.session.ident:
                raise LinkProblem(
                    f"{config.link.host}:{config.link.base_port}: the remote site does not trust this site's key; "
                    "there: `teletaction keys trust --keys FOLDER -- NAME KEY`"
                )
            status.write(now_s, site.figures())
    status.write(time.monotonic(), site.figures())
