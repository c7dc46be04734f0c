"""Records the remote site: each tick's exact input and output, and at 10 Hz what it identifies."""

import math
from collections.abc import Iterable, Mapping

import msgpack

from common.config.site_models import RemoteConfig
from common.link.session_state import Happening
from common.recording.recorder import PACKET_SCHEMA, Recorder
from common.tenderness.patient_row import Patient
from common.wire.messages import Event, Motion
from common.wire.streams import STREAMS
from remote_site.calibrated_tables import load_tables
from remote_site.devices.sensor_frame import SensorFrame
from remote_site.identification.finger_identification import FingerIdentification
from remote_site.recorded_rows import Gate, SentEvent, Thermal
from remote_site.safety.setpoints import GatedCommand

SCHEMAS: dict[str, dict[str, object]] = {
    "remote/session": Happening.schema(),
    "remote/motion": PACKET_SCHEMA,
    "remote/touch": PACKET_SCHEMA,
    "remote/sensed": SensorFrame.schema(),
    "remote/gate": Gate.schema(),
    "remote/note": {"type": "string", "description": "what the operator noted"},
    "remote/event": SentEvent.schema(),
    "remote/thermal": Thermal.schema(),
}
PATIENT_SCHEMAS: dict[str, dict[str, object]] = {"remote/patient": Patient.schema()}
"""Schemas that a recording has in addition where the patient consents to recorded pain."""
_THERMAL_EVERY = 25
"""Ticks between two records of each finger's identification: 10 a second at the usual rate."""


def open_recorder(config: RemoteConfig, metadata: Mapping[str, str], encrypt_for: str | None = None) -> Recorder | None:
    """The site's recording with the tables that it identifies by, so that replay needs nothing else.

    Args:
        config: names the file; None is returned where it names none.
        metadata: facts about the recording.
        encrypt_for: public key for whose owner the recording is encrypted; by default it is plain.

    Raises:
        ValueError: a table cannot be used.
        OSError: the file cannot be created.
    """
    if config.record is None:
        return None
    materials, surfaces = load_tables(config)
    hashes = {"materials": materials.content_hash, "surfaces": surfaces.content_hash}
    tables = {
        "materials.json": config.calibration.materials.read_bytes(),
        "surfaces.json": config.calibration.surfaces.read_bytes(),
    }
    pain = config.consent is not None and config.consent.pain
    schemas = SCHEMAS | PATIENT_SCHEMAS if pain else SCHEMAS
    return Recorder(config.record, schemas, {**metadata, **hashes}, tables, encrypt_for=encrypt_for)


class SiteRecording:
    """Writes one tick after the other."""

    def __init__(self, recorder: Recorder):
        """Write to a recorder that was opened by `open_recorder`."""
        self._recorder = recorder
        self._patient: Patient | None = None
        self._ticks = 0
        self._motion: Motion | None = None

    def session(self, now_ns: int, happenings: Iterable[Happening], notes: Iterable[str]) -> None:
        """Write what happened to the session, and what the operator noted."""
        for happening in happenings:
            self._recorder.write("remote/session", now_ns, happening.pack())
        for note in notes:
            self._recorder.write("remote/note", now_ns, msgpack.packb(note))

    def patient(self, now_ns: int, pain: float | None, limit_n: float | None) -> None:
        """Write what the patient reports, 0..10, NaN while unknown, None without a slider; and the force limit, N."""
        if pain is None:
            return
        row = Patient(None if math.isnan(pain) else pain, limit_n)
        if row != self._patient:
            self._patient = row
            self._recorder.write("remote/patient", now_ns, row.pack())

    def tick(
        self,
        now_ns: int,
        motion: Motion | None,
        sensed_now: SensorFrame,
        packet: bytes | None,
        happened: Iterable[Event],
        command: GatedCommand,
        touches: Mapping[int, FingerIdentification],
    ) -> None:
        """Write one tick that has just been done.

        Args:
            now_ns: when it began, this site's clock.
            motion: the newest accepted one.
            sensed_now: what the devices said.
            packet: the touch that was sent; None when none was.
            happened: what was identified and travels as events.
            command: what left for the devices.
            touches: what is identified of each finger in use.
        """
        recorder = self._recorder
        if motion is not None and motion is not self._motion:
            recorder.write("remote/motion", now_ns, motion.encode())
            self._motion = motion
        recorder.write("remote/sensed", now_ns, sensed_now.pack())
        if packet is not None and STREAMS["touch"].recorded:
            recorder.write("remote/touch", now_ns, packet)
        for event in happened:
            sent = SentEvent(event.ident, event.kind, event.finger, event.time_ns, event.value, event.name)
            recorder.write("remote/event", event.time_ns, sent.pack())
        gate = Gate(command.x_m, command.y_m, command.z_m, command.heater_drive, command.limited, command.fault)
        recorder.write("remote/gate", now_ns, gate.pack())
        if self._ticks % _THERMAL_EVERY == 0:
            for finger, touch in touches.items():
                recorder.write("remote/thermal", now_ns, _thermal(finger, touch).pack())
        self._ticks += 1


def _thermal(finger: int, touch: FingerIdentification) -> Thermal:
    answer = touch.thermal.answer
    return Thermal(
        finger,
        answer.status,
        answer.best,
        answer.probability,
        answer.object_c,
        answer.object_c_sd,
        answer.rate_per_s,
        answer.exponential_object_c,
        answer.exponential_material,
        answer.reason.code or None,
        touch.roughness_v,
        touch.surface.stiffness_n_m if touch.surface.known else None,
    )
