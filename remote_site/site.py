"""The remote site's loop: read the devices, identify, pass the gate, write; and serve the operator."""

import logging
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import msgpack

from common.capabilities import capabilities
from common.config import RemoteConfig, to_toml
from common.desk import Desk
from common.fingers import FINGERS
from common.keys import TrustedKeys, fingerprint, load_keys
from common.link import RemoteLink
from common.messages import Event, Motion
from common.packets import LinkState
from common.recording import PACKET_SCHEMA, SESSION_SCHEMA, Recorder, recording_figures
from common.session import Refused
from common.site_loop import run_site_loop
from common.startup import wait_for_devices
from common.streams import STREAMS
from remote_site import sensed
from remote_site.devices import RemoteDevices
from remote_site.material_table import MaterialTable
from remote_site.patient_gate import GatedCommand, PatientGate, limit_names
from remote_site.perception import Perception
from remote_site.sensed import Sensed
from remote_site.session_server import SessionServer
from remote_site.surface_class import SurfaceTable

log = logging.getLogger(__name__)

SCHEMAS: dict[str, dict[str, object]] = {
    "remote/session": SESSION_SCHEMA,
    "remote/motion": PACKET_SCHEMA,
    "remote/touch": PACKET_SCHEMA,
    "remote/sensed": sensed.SCHEMA,
    "remote/gate": {
        "type": "array",
        "description": "[x_m, y_m, z_m x 5, heater drive x 5, limits x 5, fault or null]: what left for the devices",
    },
    "remote/note": {"type": "string", "description": "what the operator noted"},
    "remote/event": {"type": "array", "description": "[id, kind, finger, time_ns, value, name]"},
    "remote/thermal": {
        "type": "array",
        "description": "[finger, status, best, probability, object_c, object_c_sd, rate_per_s, exponential_object_c, "
        "exponential_material, reason, roughness_v, stiffness_n_m]",
    },
}
_THERMAL_EVERY = 50
"""Ticks between two records of each finger's identification: 10 Hz."""


class RemoteSite:
    """One tick at a time; everything that computes is pure and in its own file."""

    def __init__(
        self,
        config: RemoteConfig,
        link: RemoteLink,
        devices: RemoteDevices,
        recorder: Recorder | None = None,
        desk: Desk | None = None,
        stamp_ns: Callable[[], int] | None = None,
    ):
        self._devices = devices
        self._recorder = recorder
        self._desk = desk
        materials, surfaces = load_tables(config)
        self.perception = Perception(config.fingers, materials, surfaces)
        self.gate = PatientGate(config.patient.contact_force_n)
        able = capabilities(
            config.fingers,
            config.rate_hz,
            materials=list(materials.names()),
            calibration=materials.content_hash,
            surfaces=surfaces.content_hash,
            contact_force_n=config.patient.contact_force_n,
            max_age_s=config.link.max_age_s,
        )
        self.server = SessionServer(link, able, config.link.max_age_s, config.link.gap_s, stamp_ns)
        self._link = link
        self._gap_ns = round(config.link.gap_s * 1e9)
        self._now_ns = 0
        self._ticks = 0
        self._sequence = 0
        self._limited: list[int] = []
        self._recorded_motion: Motion | None = None
        self.touches_sent = 0

    def tick(self, now_ns: int) -> None:
        """Read, identify, gate, write, tell."""
        now_s = now_ns * 1e-9
        self._now_ns = now_ns
        sensed_now = self._devices.read(now_s)
        if self._desk is not None:
            self._desk.serve(now_ns, self._ask)
        missing = self._devices.missing()
        self.server.session.equipped(missing)
        self.server.step(now_ns, self.gate.fault or missing, self._devices.unconfirmed)
        if self.gate.fault is not None and self.server.session.state is not LinkState.FAULT:
            self.gate.clear_fault()  # the session was cleared by a person, and the gate with it
        for fault in self._devices.faults():
            self.gate.trip(fault)
        notes = self.server.take_notes()
        happened = self.perception.step(sensed_now)
        command = self._gated(now_ns, sensed_now)
        self._limited = command.limited
        self._devices.write(command, sensed_now)
        packet = self._tell(now_ns)
        happenings = self.server.session.take_happenings()
        if self._recorder is not None:
            self._record(self._recorder, now_ns, sensed_now, happened, command, packet)
            for happening in happenings:
                self._recorder.write("remote/session", now_ns, happening.pack())
            for note in notes:
                self._recorder.write("remote/note", now_ns, msgpack.packb(note))
        self._ticks += 1

    def figures(self) -> dict[str, object]:
        """What the status file tells."""
        server = self.server
        return {
            "state": server.session.state.name.lower(),
            "fault": server.session.fault,
            "missing": self._devices.missing(),
            "estop": server.stopped,
            "observers": len(server.observers),
            "devices": self._devices.figures(),
            "limited": {FINGERS[finger]: limit_names(bits) for finger, bits in enumerate(self._limited) if bits},
            "sent": {"touch": self.touches_sent},
            "received": {"motion": server.acceptance.received},
            "superseded": {"motion": server.acceptance.lost},
            "refused": {"motion": dict(server.acceptance.refused), "damaged": dict(server.damaged)},
            "handshakes": dict(self._link.handshakes),
            "age_ms": round(server.acceptance.age_ns * 1e-6, 3),
            "max_age_ms": round(server.acceptance.max_age_ns * 1e-6, 3),
            **recording_figures(self._recorder),
        }

    def recheck_keys(self) -> None:
        """Take account of keys that were revoked; called once a second."""
        revoked = self._link.recheck_keys()
        if revoked:
            log.warning("revoked: %s", ", ".join(fingerprint(key) for key in revoked))
            self.server.cut(revoked)

    def _ask(self, verb: str, details: dict[str, Any]) -> dict[str, Any]:
        """What a person at the patient's side may ask for."""
        server = self.server
        session = server.session
        match verb:
            case "status":
                pass
            case "disengage":
                session.disengage("asked for at the remote site")
            case "estop":
                server.stop(self._now_ns, "emergency stop at the remote site", cleared_here_only=True)
            case "clear_fault":
                session.clear()
            case _:
                raise Refused(f"{verb} is for the operator's site to ask")
        if verb != "status":
            log.info("desk: %s, now %s", verb, session.state.name.lower())
        return {
            "state": session.state.name.lower(),
            "fault": session.fault,
            "missing": self._not_ready(),
            "estop": server.stopped,
        }

    def _not_ready(self) -> str:
        return self.gate.fault or self._devices.missing()

    def _gated(self, now_ns: int, now: Sensed) -> GatedCommand:
        server, devices = self.server, self._devices
        measured = devices.telemanipulator.measured
        session = server.session
        gap_ns = server.acceptance.gap_ns(now_ns) if server.both_engaged else None
        motion = server.motion
        fresh = gap_ns is not None and gap_ns <= self._gap_ns and motion is not None
        wanted = motion.block.tolist() if fresh and motion is not None else []
        hand_x, hand_y = (wanted[2][0], wanted[2][1]) if wanted else (now.x_m, now.y_m)
        touches = self.perception.touches
        command = self.gate.step(
            now.time_s,
            server.both_engaged and fresh,
            gap_ns * 1e-9 if gap_ns is not None else 1e9,
            wanted_x_m=hand_x,
            wanted_y_m=hand_y,
            wanted_z_m=[row[2] for row in wanted] or now.z_m,
            measured_x_m=now.x_m,
            measured_y_m=now.y_m,
            measured_z_m=now.z_m,
            force_n=now.force_n,
            force_age_s=now.time_s - measured.oldest_s,
            heater_drive=[t.heater_drive if (t := touches.get(f)) else 0.0 for f in range(len(FINGERS))],
            sensor_c=devices.sensor_c,
            sensor_age_s=[now.time_s - s for s in devices.sensor_s],
            in_contact=[bool((t := touches.get(f)) and t.contact) for f in range(len(FINGERS))],
        )
        if command.fault is not None:
            session.latch(command.fault)
        return command

    def _tell(self, now_ns: int) -> bytes | None:
        session = self.server.session
        if not session.ident:
            self._sequence = 0
            return None
        self._sequence += 1
        packet = self.perception.packet(session.ident, self._sequence, now_ns, session.state).encode()
        self._link.send_latest("touch", packet)
        if self.server.observers:
            self._link.send_latest("observed", packet)
        self.touches_sent += 1
        return packet

    def _record(
        self,
        recorder: Recorder,
        now_ns: int,
        now: Sensed,
        happened: list[Event],
        command: GatedCommand,
        packet: bytes | None,
    ) -> None:
        motion = self.server.motion
        if motion is not None and motion is not self._recorded_motion:
            recorder.write("remote/motion", now_ns, motion.encode())
            self._recorded_motion = motion
        recorder.write("remote/sensed", now_ns, now.pack())
        if packet is not None and STREAMS["touch"].recorded:
            recorder.write("remote/touch", now_ns, packet)
        for event in happened:
            fields = [event.ident, int(event.kind), event.finger, event.time_ns, event.value, event.name]
            recorder.write("remote/event", event.time_ns, msgpack.packb(fields))
        gated = [command.x_m, command.y_m, command.z_m, command.heater_drive, command.limited, command.fault]
        recorder.write("remote/gate", now_ns, msgpack.packb(gated))
        if self._ticks % _THERMAL_EVERY:
            return
        for finger, touch in self.perception.touches.items():
            recorder.write("remote/thermal", now_ns, msgpack.packb([finger, *_thermal(touch)]))


def _thermal(touch: Any) -> list[object]:
    answer = touch.thermal
    return [
        int(answer.status),
        answer.best,
        answer.probability,
        answer.object_c,
        answer.object_c_sd,
        answer.rate_per_s,
        answer.exponential_object_c,
        answer.exponential_material,
        answer.reason,
        touch.roughness_v,
        touch.stiffness_n_m,
    ]


def load_tables(config: RemoteConfig) -> tuple[MaterialTable, SurfaceTable]:
    """Read the site's calibrated tables; raises ValueError when one cannot be used."""
    return MaterialTable.load(config.calibration.materials), SurfaceTable.load(config.calibration.surfaces)


def _recorder(config: RemoteConfig, metadata: dict[str, str]) -> Recorder | None:
    """The site's recording with the tables that it identifies by, so that replay needs nothing else."""
    if config.record is None:
        return None
    materials, surfaces = load_tables(config)
    hashes = {"materials": materials.content_hash, "surfaces": surfaces.content_hash}
    tables = {
        "materials.json": config.calibration.materials.read_bytes(),
        "surfaces.json": config.calibration.surfaces.read_bytes(),
    }
    return Recorder(config.record, SCHEMAS, metadata | hashes, tables)


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
        desk = opened.enter_context(Desk(config.desk_port, keys))
        devices = RemoteDevices(config)
        opened.callback(devices.close)
        if not wait_for_devices(devices, config.wait_for_devices_s, stop):
            return
        recorder = _recorder(config, {"configuration": to_toml(config), "key": fingerprint(keys.public)})
        if recorder is not None:
            opened.enter_context(recorder)
        site = RemoteSite(config, link, devices, recorder, desk, time.monotonic_ns)
        run_site_loop(site, "remote", config.rate_hz, stop, status=config.status, each_second=site.recheck_keys)
