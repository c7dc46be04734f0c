"""The remote site's loop: read the devices, identify, pass the gate, write; and serve the operator."""

import logging
import time
from collections.abc import Callable
from typing import Any

import msgpack

from common.config import RemoteConfig, to_toml
from common.fingers import FINGERS
from common.keys import TrustedKeys, fingerprint, load_keys
from common.link import RemoteLink
from common.loop import PeriodicLoop, become_timely
from common.messages import Event
from common.packets import SCHEMA_VERSION, LinkState
from common.process import StatusFile
from common.recording import PACKET_SCHEMA, Recorder
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

    def __init__(self, config: RemoteConfig, link: RemoteLink, devices: RemoteDevices, recorder: Recorder | None):
        self._devices = devices
        self._recorder = recorder
        materials, surfaces = load_tables(config)
        self.perception = Perception(config.fingers, materials, surfaces)
        self.gate = PatientGate(config.patient.contact_force_n)
        capabilities = {
            "schema": SCHEMA_VERSION,
            "fingers": list(config.fingers),
            "rate_hz": config.rate_hz,
            "materials": materials.names(),
            "calibration": materials.content_hash,
        }
        self.server = SessionServer(link, capabilities, config.link.max_age_s)
        self._link = link
        self._gap_ns = round(config.link.gap_s * 1e9)
        self._ticks = 0
        self._sequence = 0
        self._limited: list[int] = []
        self.touches_sent = 0

    def tick(self, now_ns: int) -> None:
        """Read, identify, gate, write, tell."""
        now_s = now_ns * 1e-9
        sensed_now = self._devices.read(now_s)
        self.server.step(now_ns, self._not_ready())
        if self.gate.fault is not None and self.server.session.state is not LinkState.FAULT:
            self.gate.clear_fault()  # the session was cleared by a person, and the gate with it
        notes = self.server.take_notes()
        happened = self.perception.step(sensed_now)
        command = self._gated(now_ns, sensed_now)
        self._limited = command.limited
        self._devices.write(command, sensed_now)
        packet = self._tell(now_ns)
        if self._recorder is not None:
            self._record(self._recorder, now_ns, sensed_now, happened, command, packet)
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
            "devices": self._devices.figures(),
            "limited": {FINGERS[finger]: limit_names(bits) for finger, bits in enumerate(self._limited) if bits},
            "sent": {"touch": self.touches_sent},
            "received": {"motion": server.acceptance.received},
            "superseded": {"motion": server.acceptance.lost},
            "refused": {"motion": dict(server.acceptance.refused), "damaged": dict(server.damaged)},
            "recorded": {} if self._recorder is None else dict(self._recorder.written),
            "recording_lost": 0 if self._recorder is None else self._recorder.lost,
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
            force_age_s=now.time_s - measured.force_s,
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


def run_remote(config: RemoteConfig, stop: Callable[[], bool]) -> None:
    """Run the remote site until `stop()`.

    Raises:
        ValueError, OSError: keys, tables, devices or the link cannot be used; the message says which and why.
    """
    keys = load_keys(config.link.keys)
    trusted = TrustedKeys(config.link.keys)
    trusted.names()  # a damaged list is said now, not when the first operator is refused
    load_tables(config)
    devices = RemoteDevices(config)
    try:
        with RemoteLink(config.link.bind, config.link.base_port, keys, trusted) as link:
            log.info("bound to %s:%d as %s", config.link.bind, config.link.base_port, fingerprint(keys.public))
            wait_for_devices(devices, config.wait_for_devices_s)
            metadata = {"configuration": to_toml(config), "key": fingerprint(keys.public)}
            recorder = None if config.record is None else Recorder(config.record, SCHEMAS, metadata)
            try:
                _loop(RemoteSite(config, link, devices, recorder), config, stop)
            finally:
                if recorder is not None:
                    recorder.close()
    finally:
        devices.close()


def _loop(site: RemoteSite, config: RemoteConfig, stop: Callable[[], bool]) -> None:
    become_timely()
    loop = PeriodicLoop(1.0 / config.rate_hz)
    status = StatusFile(config.status, "remote", loop)
    while not stop():
        loop.wait()
        site.tick(time.monotonic_ns())
        now_s = time.monotonic()
        if status.due(now_s):
            status.write(now_s, site.figures())
    status.write(time.monotonic(), site.figures())
