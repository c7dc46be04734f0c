"""The remote site's loop: read the devices, identify, pass the gate, write; and serve the operator."""

import logging
import math
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from typing import Any

from msgspec import structs

from common.buses.device_startup import wait_for_devices
from common.config.file import to_toml
from common.config.site_models import RemoteConfig
from common.faults.fault import FaultCode, contained
from common.faults.texts import fault_text
from common.fingers import FINGERS
from common.link.capabilities import capabilities
from common.link.clock_offset import ReadClock
from common.link.deadband import Deadband, Places, touch_perceptible
from common.link.keys import TrustedKeys, fingerprint, load_keys
from common.link.link import RemoteLink
from common.link.link_sides import RemoteSide
from common.link.local_control import LocalControl, LocalControlSocket
from common.recording.recorder import Recorder
from common.runtime.containment import Containment, MakeContainment
from common.runtime.site_loop import run_site_loop
from common.site_status import recording_stopped, site_figures, staleness
from common.tenderness.presses import PAINFUL
from common.timing.standstill import HostClock
from common.timing.timeouts import REFRESH_S, SECOND_REFRESH_S, TICK_AGE_S
from common.wire.messages import Motion, Touch
from common.wire.noted_consent import NotedConsent
from common.wire.packets import LinkState
from remote_site.calibrated_tables import load_tables
from remote_site.devices.devices import RemoteDevices
from remote_site.devices.sensor_frame import HandPlace, SensorFrame, with_sensors_in_doubt
from remote_site.heating import Heating
from remote_site.identification.perception import Perception, nothing_touched
from remote_site.safety.limit_flags import HEATER_TEST, Limit, limit_names
from remote_site.safety.patient_gate import PatientGate
from remote_site.safety.setpoints import GatedCommand
from remote_site.session.local_control import answer_desk
from remote_site.session.pain_file import PainFile
from remote_site.session.session_server import SessionServer
from remote_site.session.stop_file import StopFile
from remote_site.site_recording import SiteRecording, open_recorder

log = logging.getLogger(__name__)

HAND = FINGERS.index("middle")
"""Number of the finger whose place is the hand's."""
_ZEROS = (0.0,) * len(FINGERS)
_NOTHING_NEW = (None,) * len(FINGERS)
_GATE_RESTS_S = 2.0 * TICK_AGE_S
"""Time for which a gate that raised is not stepped, s; after more than TICK_AGE_S it starts from the measured place."""


class RemoteSite:
    """Runs one tick at a time; all computation is pure and in other files.

    An exception in a step of the tick is contained: the gate is stepped as not engaged, and the fault latches. If the
    gate itself raises, the telemanipulator is released at its place, heaters go off, and the gate is stepped again
    only when it starts from the measured place. If a device's driver raises, the device's own time-out turns it off.
    An exception of the recording is reported and stops nothing.
    """

    def __init__(
        self,
        config: RemoteConfig,
        link: RemoteSide,
        devices: RemoteDevices,
        recorder: Recorder | None = None,
        desk: LocalControl | None = None,
        stamp_ns: ReadClock | None = None,
        containment: MakeContainment = Containment,
        stop_file: StopFile | None = None,
        pain_file: PainFile | None = None,
    ):
        self._devices = devices
        self._recorder = recorder
        self._recording = None if recorder is None else SiteRecording(recorder)
        answers = config.consent
        self._consent = NotedConsent(None if answers is None else tuple(kind for kind, agreed in answers if agreed))
        self._stop_file, self._pain_file = stop_file, pain_file
        self._pain_recorded = answers is not None and answers.pain
        self._desk = desk
        materials, surfaces = load_tables(config)
        self.gate = PatientGate(config.patient.contact_force_n)
        if pain_file is not None and (limit_n := pain_file.limit_n()) is not None:
            self.gate.continue_pain_limit(limit_n)
        able = capabilities(
            config.fingers,
            config.rate_hz,
            materials=list(materials.names()),
            calibration=materials.content_hash,
            calibrated=materials.described(),
            surfaces=surfaces.content_hash,
            **self._consent.details(),
            **({} if surfaces.roughness_scale is None else {"roughness_um": surfaces.roughness_scale.model_dump()}),
            contact_force_n=config.patient.contact_force_n,
            max_age_s=config.link.max_age_s,
        )
        self.server = SessionServer(link, able, config.link.max_age_s, config.link.gap_s, stamp_ns)
        self.contain = self.server.contain = containment(self.server.session.latch)
        if stop_file is not None and (before := stop_file.latched()) is not None:
            here = before.code is not FaultCode.OPERATOR_STOP
            self.server.session.latch(before, cleared_here_only=here)
        self.server.recording_stopped = partial(recording_stopped, recorder, self.contain)
        self.server.patient = self._patient
        self.perception = Perception(config.fingers, materials, surfaces, self.contain, 1.0 / config.rate_hz)
        self.heating = Heating(config.fingers)
        self._sensed = SensorFrame(-math.inf, 0.0, 0.0, _ZEROS, _ZEROS, _NOTHING_NEW, _NOTHING_NEW, None)
        self._command = GatedCommand(False, True, 0.0, 0.0, [*_ZEROS], [*_ZEROS], [0] * len(FINGERS), None)
        self._gate_raised_s = -math.inf
        self._hand_of: Motion | None = None
        self._hand: HandPlace | None = None
        self._link = link
        self._gap_ns = round(config.link.gap_s * 1e9)
        self._deadband = Deadband(1.0 / config.rate_hz) if config.link.deadband else None
        self._sent: Touch | None = None
        self._now_ns = 0
        self.touches_sent = 0

    def tick(self, now_ns: int) -> None:
        """Read, serve the session, identify, gate, write, send touch, record; then do slow work that is due."""
        server, contain = self.server, self.contain
        if server.session.state is not LinkState.FAULT:
            contain.not_latched()
        sensed_now = self._sensed = self._plausible(self._read(now_ns * 1e-9))
        now_ns += self._devices.tick.stood_still_ns
        self._now_ns = now_ns
        with contain.step("session"):
            self._serve(now_ns)
        happened = self.perception.step(sensed_now)
        heater_drive = [*_ZEROS]
        with contain.step("heat"):
            heater_drive = self.heating.step(sensed_now, self.perception.touches)
        followed = None
        with contain.step("follow"):
            followed = self._places(now_ns)
        command = self._command = self._commanded(sensed_now, followed, heater_drive)
        if command.fault is not None:
            server.session.latch(command.fault)
        with contain.step("write"):
            self._devices.write(command, sensed_now)
        if self._stop_file is not None:
            self._stop_file.keep(server.session.stop)
        if self._pain_file is not None:
            self._pain_file.keep_limit(self.gate.pain_limit.limit_n)
        packet = self._touch(now_ns)
        happenings, notes = server.session.take_happenings(), server.take_notes()
        if self._recording is not None:
            touches = self.perception.touches
            with contain.step("record", latches=False):
                self._recording.tick(now_ns, server.motion, sensed_now, packet, happened, command, touches)
                self._recording.session(now_ns, happenings, notes)
                if self._pain_recorded:
                    self._recording.patient(
                        now_ns, self._devices.pain_reading(now_ns * 1e-9), self.gate.patient_limit_n
                    )
        self.perception.work()

    def _read(self, now_s: float) -> SensorFrame:
        """Return the readings of the devices; if reading fails, a frame without new measurements."""
        with self.contain.step("read"):
            return self._devices.read(now_s, self._followed())
        now_s += self._devices.tick.stood_still_ns * 1e-9
        return structs.replace(self._sensed, time_s=now_s, texture_counts=_NOTHING_NEW, plates=_NOTHING_NEW, hand=None)

    def _plausible(self, sensed: SensorFrame) -> SensorFrame:
        """Return the readings; a thermal sensor's is implausible while the gate wants a test of it."""
        untested = [bool(bits & HEATER_TEST) for bits in self._command.limited]
        return with_sensors_in_doubt(sensed, untested) if any(untested) else sensed

    def _serve(self, now_ns: int) -> None:
        """Take local requests and the packets of the operator, and step the session."""
        server = self.server
        missing = self._devices.missing()
        not_ready = fault_text(self.gate.fault) or missing
        if self._desk is not None:
            self._desk.serve(now_ns, partial(self._answer_desk, now_ns, not_ready))
        server.session.equipped(missing)
        server.step(now_ns, not_ready, self._devices.unconfirmed)
        if self.gate.fault is not None and server.session.state is not LinkState.FAULT:
            self.gate.clear_fault()  # a person has cleared the session, and with it the gate
        for fault in self._devices.faults():
            self.gate.trip(fault)

    def _answer_desk(self, now_ns: int, not_ready: str, verb: str, details: dict[str, Any]) -> dict[str, Any]:
        with self.contain.request("desk"):
            pain = self._devices.pain_reading(now_ns * 1e-9)
            may_restore = pain is None or pain < PAINFUL
            return answer_desk(
                self.server,
                now_ns,
                not_ready,
                verb,
                held=self._devices.patient_presses,
                restore_force=self.gate.end_pain_limit if may_restore else None,
            )

    def _patient(self) -> dict[str, Any]:
        """Return what the patient reports, for the operator's site; empty without a pain slider and a limit of it."""
        pain, limit_n = self._devices.pain_reading(self._now_ns * 1e-9), self.gate.patient_limit_n
        if pain is None and limit_n is None:
            return {}
        return {
            "pain": None if pain is None or math.isnan(pain) else pain,
            "patient_limit_n": limit_n,
            "pain_reports": [value for report in self.gate.pain_limit.reports for value in report],
            "pain_agreed": self._pain_recorded,
        }

    def _commanded(
        self, now: SensorFrame, followed: tuple[float, Places] | None, heater_drive: list[float]
    ) -> GatedCommand:
        """Return the gate's command; if the gate has raised, release the telemanipulator and turn heaters off."""
        fault = self.server.session.fault
        if not 0.0 <= now.time_s - self._gate_raised_s < _GATE_RESTS_S:
            with self.contain.step("gate"):
                return self._gated(now, followed, heater_drive)
            self._gate_raised_s = now.time_s
            fault = contained(self.contain.latest["gate"])
        limited = [Limit.RELEASED.value] * len(FINGERS)
        return replace(self._command, released=True, heater_drive=[*_ZEROS], limited=limited, fault=fault)

    def figures(self) -> dict[str, object]:
        """Return the figures for the status file."""
        server = self.server
        limited = [limit_names(bits) for bits in self._command.limited]
        sent = {"touch": self.touches_sent}
        stale = staleness(server, "motion", self._now_ns, self._gap_ns * 1e-9)
        spared = {"touch": 0 if self._deadband is None else self._deadband.spared}
        touches = self.perception.touches
        faults = {FINGERS[finger]: touch.texture_fault for finger, touch in touches.items() if touch.texture_fault}
        return {
            **site_figures(
                server,
                self._devices,
                self._recorder,
                limited,
                sent=sent,
                spared=spared,
                contain=self.contain,
                acts_on="motion",
                stale=stale,
            ),
            "texture_faults": faults,
            "postponed": self.perception.postponed,
            **self._patient(),
            "left_mj": dict(zip(FINGERS, self.gate.left_mj, strict=True)),
            "operator": fingerprint(server.operator) if server.operator else "",
            "observers": len(server.observers),
            "expelled": dict(server.expelled),
            "handshakes": dict(self._link.handshakes),
            "keys": self._link.keys_problem,
            "stop_file": "" if self._stop_file is None else self._stop_file.problem,
            "pain_file": "" if self._pain_file is None else self._pain_file.problem,
        }

    def recheck_keys(self) -> None:
        """End the sessions of revoked keys; called once a second."""
        revoked = self._link.recheck_keys()
        if revoked:
            log.warning("revoked: %s", ", ".join(fingerprint(key) for key in revoked))
            self.server.cut(revoked)

    def _followed(self) -> HandPlace | None:
        """Return the operator's hand in the newest motion while it is followed; else None."""
        motion = self.server.motion
        if motion is None or not self.server.both_engaged:
            return None
        if motion is not self._hand_of:
            hand = motion.rows[HAND]
            self._hand_of, self._hand = motion, HandPlace(motion.time_ns, hand.x_m, hand.y_m)
        return self._hand

    def _places(self, now_ns: int) -> tuple[float, Places] | None:
        """Return the age of the newest motion, s, and the fingertips' places now; None if no motion may act."""
        server = self.server
        gap_ns = server.acceptance.gap_ns(now_ns) if server.both_engaged else None
        if gap_ns is None or gap_ns > self._gap_ns or (places := server.places(now_ns)) is None:
            return None
        return gap_ns * 1e-9, places

    def _gated(
        self, now: SensorFrame, followed: tuple[float, Places] | None, heater_drive: list[float]
    ) -> GatedCommand:
        devices = self._devices
        in_contact = [False] * len(FINGERS)
        for finger, touch in self.perception.touches.items():
            in_contact[finger] = bool(touch.contact)
        measured = devices.telemanipulator.measured
        age_s, wanted = followed or (1e9, [])
        hand_x, hand_y = (wanted[HAND].x_m, wanted[HAND].y_m) if wanted else (now.x_m, now.y_m)
        return self.gate.step(
            now.time_s,
            # Without set-points the telemanipulator stops by itself, and begins again where it is.
            self.server.both_engaged and followed is not None and devices.follows,
            age_s,
            wanted_x_m=hand_x,
            wanted_y_m=hand_y,
            wanted_z_m=[row.z_m for row in wanted] or now.z_m,
            measured_x_m=now.x_m,
            measured_y_m=now.y_m,
            measured_z_m=now.z_m,
            force_n=now.force_n,
            force_age_s=now.time_s - measured.oldest_s,
            heater_drive=heater_drive,
            sensor_c=devices.sensor_c,
            ambient_c=devices.ambient_c,
            sensor_age_s=[now.time_s - s for s in devices.sensor_s],
            in_contact=in_contact,
            patient_switch=devices.switch_reading(now.time_s),
            pain=devices.pain_reading(now.time_s),
        )

    def _touch(self, now_ns: int) -> bytes | None:
        """Send touch; if that fails, send a touch with this site's fault and without contact."""
        with self.contain.step("touch"):
            return self._send_touch(now_ns, self.perception.packet)
        with self.contain.step("touch"):
            return self._send_touch(now_ns, nothing_touched)
        return None

    def _send_touch(self, now_ns: int, packet_of: Callable[[int, int, int, LinkState], Touch]) -> bytes | None:
        session, sent = self.server.session, self._sent
        if sent is not None and sent.session != session.ident:
            sent = self._sent = None
        if not session.ident:
            return None
        sequence = 1 if sent is None else sent.sequence + 1
        touch = packet_of(session.ident, sequence, now_ns, session.state)
        if self._deadband is not None:
            changed = sent is None or touch_perceptible(sent, touch)
            refresh_s = SECOND_REFRESH_S if self.server.on_two_connections(now_ns) else REFRESH_S
            if not self._deadband.step(now_ns * 1e-9, changed, refresh_s):
                return None
        self._sent, packet = touch, touch.encode()
        self._link.send_latest("touch", packet)
        if self.server.observers:
            self._link.send_latest("observed", packet)
        self.touches_sent += 1
        return packet


def run_remote(config: RemoteConfig, stop: Callable[[], bool]) -> None:
    """Run the remote site until `stop()`.

    Raises:
        ValueError, OSError: keys, tables, devices or the link cannot be used; the message says which and why.
    """
    keys = load_keys(config.link.keys)
    load_tables(config)
    with ExitStack() as opened:
        link = opened.enter_context(
            RemoteLink(config.link.bind, config.link.base_port, keys, TrustedKeys(config.link.keys))
        )
        log.info("bound to %s:%d as %s", config.link.bind, config.link.base_port, fingerprint(keys.public))
        desk = opened.enter_context(LocalControlSocket(config.desk_port, keys))
        clock = HostClock()
        devices = RemoteDevices(config, clock)
        opened.callback(devices.close)
        if not wait_for_devices(devices, config.wait_for_devices_s, stop):
            return
        metadata = {"configuration": to_toml(config), "key": fingerprint(keys.public)}
        recorder = open_recorder(config, metadata, keys.public if config.recording.encrypt else None)
        if recorder is not None:
            opened.enter_context(recorder)
        stop_file = opened.enter_context(StopFile(config.status))
        pain_file = opened.enter_context(PainFile(config.status))
        site = RemoteSite(config, link, devices, recorder, desk, clock.now_ns, stop_file=stop_file, pain_file=pain_file)
        run_site_loop(
            site,
            "remote",
            config.rate_hz,
            stop,
            status=config.status,
            each_second=site.recheck_keys,
            clock_ns=clock.now_ns,
        )
