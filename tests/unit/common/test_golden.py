"""Every golden block of docs/protocols.md, both ways through the code that drivers and emulators share."""

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from common.buses.can_frames import FrameReceiver, FrameSender
from common.buses.serial_messages import (
    DeviceFlag,
    DeviceKind,
    Frame,
    FrameReader,
    HeaterCommand,
    Identity,
    MessageId,
    PatientSwitchState,
    TactTipCommand,
    TactTipState,
    TextureSamples,
    ThermalReading,
    encode_frame,
)
from common.buses.thermometry import ntc_c, ssr_c
from common.fingers import FINGERS
from common.link.capabilities import LAYOUT, MOTION_NUMBERS
from common.wire.messages import TOUCH_FIELDS, Event, EventKind, Motion, ThermalStatus, Touch, motion_rows
from common.wire.packets import SCHEMA_VERSION, LinkState
from common.wire.session_messages import Answer, Heartbeat, Request
from common.wire.touch_summary import NOTHING, TouchSummary

SESSION = 0x0123456789ABCDEF
T = 1_000_000_000_000
H = T + 5_000_000  # the operator's clock, less the time under way


@dataclass
class Nothing:
    """IDENTIFY has no payload."""

    def encode(self) -> bytes:
        return b""

    @staticmethod
    def decode(payload: bytes) -> "Nothing":
        assert not payload
        return Nothing()


SAMPLES = np.array([-2048, 2047, 0, 1, -1, 256, 100, -100, 1000, -1000], dtype="<i2").tobytes()
SERIAL: dict[str, tuple[MessageId, int, Any]] = {
    "identify": (MessageId.IDENTIFY, 0, Nothing()),
    "identity": (MessageId.IDENTITY, 0, Identity(DeviceKind.THERMAL_SENSOR, 1, "TH0001", 1, 100, 0.0, 60.0)),
    "texture_samples": (MessageId.TEXTURE_SAMPLES, 7, TextureSamples(5000, SAMPLES)),
    "thermal_reading": (MessageId.THERMAL_READING, 200, ThermalReading(1_000_000, 2210, 1610, 0, -250)),
    "heater_command": (MessageId.HEATER_COMMAND, 1, HeaterCommand(-250)),
    "tacttip_command": (MessageId.TACTTIP_COMMAND, 2, TactTipCommand(1410, -500, 3000, 24_600, 5)),
    "tacttip_state": (
        MessageId.TACTTIP_STATE,
        255,
        TactTipState(0xFFFFFFFF, 1700, 2275, DeviceFlag.THERMAL_CUT_OUT, 1410, 0),
    ),
    "patient_switch_state": (MessageId.PATIENT_SWITCH_STATE, 3, PatientSwitchState(1_000_000, closed=True)),
    "patient_switch_with_slider": (MessageId.PATIENT_SWITCH_STATE, 4, PatientSwitchState(1_000_000, True, 420)),
}
POSES = {"HandPose": (0, -170.0, 2.0), "HandSetpoint": (15, 655.34, -655.36), "HandPoseMeasured": (9, 100.0, -0.02)}
FIVES = {
    "FingerHeights": (1, (6.0, -2.0, 0.0, 0.005, -10.24)),
    "ExoskeletonState": (6, (0.25, 0.0, 2.5, 0.01, 10.23)),
    "FingerForces": (2, (0.0, 0.01, 1.25, 5.0, 10.23)),
    "HeightSetpoint": (4, (6.0, -2.0, 0.0, 10.22, -10.24)),
    "FingerHeightsMeasured": (10, (10.235, -0.005, 3.0, -3.0, 0.05)),
    "ContactForces": (11, (0.3, 0.15, 0.0, 2.0, 10.0)),
}
CAN = {name: (counter, {"x": x, "y": y}) for name, (counter, x, y) in POSES.items()} | {
    name: (counter, dict(zip(FINGERS, values, strict=True))) for name, (counter, values) in FIVES.items()
}
CAN["FingerForces"][1]["enabled"] = 1.0
CAN["ExoskeletonState"][1]["enabled"] = 0.0
CAN["HeightSetpoint"][1]["released"] = 1.0
CAN["TelemanipulatorState"] = (12, {"released": 1.0, "hand_alive": 0.0, "heights_alive": 1.0})

ALL_FINGERS = list(FINGERS)
MOTION_BLOCK = np.array([(-0.170, 0.002, z) for z in (0.006, -0.002, 0.0, 0.001, 0.01)], dtype=np.float32)
INDEX_TOUCH = {
    "mode": 3,
    "contact": 1,
    "contact_force_n": 0.75,
    "x_m": -0.1625,
    "y_m": 0.0078125,
    "surface_z_m": -0.0005,
    "stiffness_n_m": 850,
    "stiffness_ln_sd": 0.03125,
    "damping_n_s_m": 1.25,
    "slope_x": -0.0625,
    "slope_y": 0.125,
    "k_tap": 1500,
    "b_tap_per_s": 60,
    "k_stroke_v": 4000,
    "k_stroke_f": 30,
    "groove_rad_s": 300,
    "b_groove_per_s": 40,
    "conductivity_w_mk": 0.19,
    "density_kg_m3": 1400,
    "specific_heat_j_kgk": 1000,
    "object_c": 23.5,
    "effusivity_ln_sd": 0.125,
    "object_c_sd": 0.25,
    "probability": 0.9375,
    "thermal_status": ThermalStatus.IDENTIFIED,
}
UNTOUCHED = {
    "stiffness_ln_sd": 10,
    "effusivity_ln_sd": 10,
    "object_c_sd": 50,
    "thermal_status": ThermalStatus.NO_CONTACT,
}
TOUCH_BLOCK = np.array(
    [[(INDEX_TOUCH if f == "index" else UNTOUCHED).get(name, 0) for name in TOUCH_FIELDS] for f in FINGERS], np.float32
)
EVENTS = (
    Event(1, EventKind.TAP, 1, T - 200_000_000, H - 200_000_000, 0.125),
    Event(2, EventKind.MATERIAL, 1, T, H, 0.9375, "pvc"),
)
SHOWN = (
    NOTHING,
    TouchSummary((("pvc", 0.9375), ("acrylic", 0.03125)), 0.125, 0.0078125, None, None),
    *(NOTHING,) * 3,
)
SAME = {"schema": SCHEMA_VERSION, "layout": LAYOUT, "motion_numbers": MOTION_NUMBERS}
AGREED = {**SAME, "fingers": ALL_FINGERS, "rate_hz": 500.0}
REMOTE_T = T - 4_900_000
PACKETS: dict[str, Any] = {
    "motion": Motion(SESSION, 3, T, LinkState.CONNECTED, motion_rows(MOTION_BLOCK.tobytes())),
    "touch": Touch(
        SESSION,
        70_000,
        T + 4_000_000,
        LinkState.ENGAGED,
        TOUCH_BLOCK.tobytes(),
        ("", "pvc", "", "", ""),
        EVENTS,
        SHOWN,
    ),
    "heartbeat": Heartbeat(SESSION, 12, T, LinkState.ENGAGED, T, 0, -5_000_000, 150_001),
    "heartbeat_answer": Heartbeat(SESSION, 12, REMOTE_T, LinkState.ENGAGED, T, REMOTE_T, -5_000_000, 150_001),
    "hello": Request(0, 1, T, "hello", AGREED | {"force_n": 10.0, "role": "operator"}),
    "hello_answer": Answer(
        SESSION,
        1,
        T + 77,
        "",
        {"session": SESSION, "first_motion": 2} | AGREED | {"materials": ["aluminium", "pvc"], "calibration": "5f2c"},
    ),
    "engage": Request(SESSION, 2, T, "engage", {"max_age_s": 0.15}),
    "status_answer": Answer(
        SESSION,
        3,
        T + 77,
        "",
        {
            "state": "fault",
            "fault": ["sensor-plate-too-hot", "index", "", 42.25, 42.0, None, "", False],
            "missing": "",
            "recording": "",
        },
    ),
    "refusal": Answer(SESSION, 2, T + 77, "not ready: index thermal_sensor: opening", {}),
}


def test_every_block_of_the_document_is_tested(golden: dict[str, bytes]) -> None:
    assert set(golden) == {*SERIAL, *CAN, *PACKETS}


@pytest.mark.parametrize("name", SERIAL)
def test_serial(golden: dict[str, bytes], name: str) -> None:
    message_id, sequence, message = SERIAL[name]
    assert encode_frame(message_id, sequence, message.encode()) == golden[name]
    reader = FrameReader()
    (frame,) = reader.feed(golden[name])
    assert frame == Frame(message_id, sequence, message.encode())
    assert type(message).decode(frame.payload) == message
    assert reader.damaged == 0


def test_the_table_of_serial_messages_has_their_lengths() -> None:
    page = (Path(__file__).parents[3] / "docs" / "protocols.md").read_text("utf-8")
    stated = {
        int(number, 16): words for number, words in re.findall(r"^\| (0x\d\d) \| [A-Z_]+ \|.*\| (.*) \|$", page, re.M)
    }
    lengths = {message_id: len(message.encode()) for message_id, _, message in SERIAL.values()}
    del lengths[MessageId.TEXTURE_SAMPLES]  # as many as there are samples
    lengths[MessageId.PATIENT_SWITCH_STATE] = 5  # without a slider
    assert {number: int(re.split(r"\D", stated[number])[0]) for number in lengths} == lengths


def test_serial_temperatures_agree_with_the_document() -> None:
    assert (ssr_c(0), ssr_c(4095)) == (pytest.approx(0.0, abs=0.02), pytest.approx(60.0, abs=0.02))
    assert ntc_c(2047.5) == pytest.approx(25.0)
    assert ntc_c(1700) > 25.0 > ntc_c(2275)
    for broken in (0, 4095):
        with pytest.raises(ValueError, match="open or shorted"):
            ntc_c(broken)


@pytest.mark.parametrize("name", CAN)
def test_can(golden: dict[str, bytes], name: str) -> None:
    counter, values = CAN[name]
    sender, receiver = FrameSender(name), FrameReceiver(name)
    for _ in range(counter):
        sender.encode(values)
    assert bytes(sender.encode(values).data) == golden[name]
    assert receiver.decode(golden[name]) == pytest.approx(values)
    if name in FIVES:
        assert FrameReceiver(name).values(golden[name])[: len(FINGERS)] == pytest.approx(FIVES[name][1])


@pytest.mark.parametrize("name", PACKETS)
def test_packets(golden: dict[str, bytes], name: str) -> None:
    packet = PACKETS[name]
    assert packet.encode() == golden[name]
    decoded = type(packet).decode(golden[name])
    for field in packet.__slots__:
        expected, found = getattr(packet, field), getattr(decoded, field)
        assert np.array_equal(expected, found) if field == "block" else expected == found
        assert isinstance(found, type(expected))


def test_the_documents_clock_example_adds_up(golden: dict[str, bytes]) -> None:
    answer = Heartbeat.decode(golden["heartbeat_answer"])
    assert math.isclose(answer.arrived_ns - answer.sent_ns, -4.9e6)
