"""The patient's stop switch at the gate: what stops the fingers, what is a fault, and how soon they are off."""

import math
from collections import deque

import numpy as np
import pytest

from common.faults.fault import OF_THE_PATIENT, Fault, FaultCode
from common.fingers import FINGERS
from common.limits import (
    CONTACT_FORCE_N,
    LIFT_OFF_S,
    PATIENT_STOP_S,
    RETREAT_M_S,
    SWITCH_HOLD_S,
    SWITCH_LOST_S,
    SWITCH_SILENCE_S,
)
from remote_site.safety.patient_gate import PatientGate
from remote_site.safety.patient_stop import SwitchReading, patient_stop
from remote_site.safety.servo import SERVO_N_M
from remote_site.safety.setpoints import CLEAR_HEIGHT_M, HEIGHT_HIGH_M, STOP_S, TOUCHING_N
from sim_sensors.devices.patient_switch import RATE_HZ
from sim_sensors.physics.fingertip import Fingertip

PRESSED, AT_REST = SwitchReading(False, 0.0, ""), SwitchReading(True, 0.0, "")
STOPPED = Fault(FaultCode.PATIENT_STOP)
TICKS_S = (0.001, 0.002, 0.004, 0.010)
"""Of the fastest and the slowest loop, and between."""


def failed(what: str) -> Fault:
    return Fault(FaultCode.PATIENT_SWITCH_FAILED, detail=what)


@pytest.mark.parametrize(
    ("reading", "leave", "fault"),
    [
        (None, False, None),
        (AT_REST, False, None),
        (SwitchReading(True, SWITCH_SILENCE_S, ""), False, None),
        (SwitchReading(True, math.nextafter(SWITCH_SILENCE_S, 1.0), ""), True, None),
        (SwitchReading(True, SWITCH_LOST_S, ""), True, None),
        (SwitchReading(True, math.nextafter(SWITCH_LOST_S, 1.0), ""), True, failed("is silent")),
        (SwitchReading(True, math.inf, ""), True, None),
        (SwitchReading(True, math.nan, ""), True, None),
        (SwitchReading(True, -0.001, ""), True, None),
        (SwitchReading(True, 0.0, "is unplugged"), True, failed("is unplugged")),
        (SwitchReading(True, 9.0, "is unplugged"), True, failed("is unplugged")),
        (PRESSED, True, STOPPED),
        (SwitchReading(False, 9.0, "is unplugged"), True, STOPPED),
    ],
)
def test_anything_but_a_fresh_closed_contact_stops(
    reading: SwitchReading | None, leave: bool, fault: Fault | None
) -> None:
    assert patient_stop(reading) == (leave, fault)


def test_a_press_outlasts_a_silence_that_is_no_fault() -> None:
    assert SWITCH_SILENCE_S < SWITCH_LOST_S < SWITCH_HOLD_S


def test_the_time_to_lift_off_is_worked_out_from_the_retreat() -> None:
    assert pytest.approx(PATIENT_STOP_S + (0.010 + CONTACT_FORCE_N / SERVO_N_M) / RETREAT_M_S) == LIFT_OFF_S


class Pressing:
    """A gate whose middle finger presses an elastic object, with what it reports and obeys two ticks late."""

    def __init__(self, dt_s: float, surface_m: float, stiffness_n_m: float) -> None:
        self.gate, self.tip, self.dt_s, self.t_s = PatientGate(), Fingertip(CLEAR_HEIGHT_M), dt_s, 0.0
        self.surface_m, self.stiffness_n_m = surface_m, stiffness_n_m
        self.sent = deque([(CLEAR_HEIGHT_M, True)] * 2, maxlen=2)
        self.seen = deque([(CLEAR_HEIGHT_M, 0.0)] * 2, maxlen=2)
        self.held_m: float | None = None

    def step(
        self, wanted_m: float = -0.010, switch: SwitchReading | None = AT_REST, age_s: float = 0.0
    ) -> Fault | None:
        self.t_s += self.dt_s
        asked_m, released = self.sent[0]
        # As the telemanipulator does: released, it stops where it is, and then only rises.
        self.held_m = max(self.tip.z_m if self.held_m is None else self.held_m, asked_m) if released else None
        servo_m = asked_m if self.held_m is None else self.held_m
        self.tip.step(self.dt_s, servo_m, self.surface_m, self.stiffness_n_m)
        z_m, force_n = self.seen[0]
        self.seen.append((self.tip.z_m, self.tip.force_n))
        middle = FINGERS.index("middle")

        def five(value: float, other: float) -> list[float]:
            return [value if finger == middle else other for finger in range(len(FINGERS))]

        out = self.gate.step(
            self.t_s,
            True,
            age_s,
            wanted_x_m=0.0,
            wanted_y_m=0.0,
            wanted_z_m=five(-0.010, CLEAR_HEIGHT_M),
            measured_x_m=0.0,
            measured_y_m=0.0,
            measured_z_m=five(z_m, CLEAR_HEIGHT_M),
            force_n=five(force_n, 0.0),
            force_age_s=0.0,
            heater_drive=[0.0] * 5,
            sensor_c=[30.0] * 5,
            ambient_c=[23.0] * 5,
            sensor_age_s=[0.0] * 5,
            in_contact=[False] * 5,
            patient_switch=switch,
        )
        self.sent.append((out.z_m[middle], out.released))
        return out.fault

    def press(self, seconds: float = 4.0) -> None:
        for _ in range(round(seconds / self.dt_s)):
            assert self.step() is None


@pytest.mark.parametrize("dt_s", TICKS_S)
@pytest.mark.parametrize(("surface_m", "stiffness_n_m"), [(0.005, 450.0), (0.0, 800.0), (0.0, 20_000.0)])
@pytest.mark.parametrize("age_s", [0.0, 9.0])
def test_force_falls_within_150_ms_of_a_press_and_the_finger_is_off_in_time(
    dt_s: float, surface_m: float, stiffness_n_m: float, age_s: float
) -> None:
    """With a soft object the finger is 10 mm deep at the limit of the force; a cut network changes nothing."""
    rig = Pressing(dt_s, surface_m, stiffness_n_m)
    rig.press()
    deep_m = surface_m - rig.tip.z_m
    assert rig.tip.force_n > 0.85 * CONTACT_FORCE_N
    if surface_m > 0.0:
        assert deep_m == pytest.approx(0.010, abs=0.0005)
    forces, late = [rig.tip.force_n], round(1.0 / RATE_HZ / dt_s)  # until the switch reports the press
    for tick in range(round(LIFT_OFF_S / dt_s)):
        rig.step(switch=PRESSED if tick >= late else AT_REST, age_s=age_s)
        forces.append(rig.tip.force_n)
    rises = np.flatnonzero(np.diff(forces) > 1e-3)
    falls_s, off_s = (rises[-1] + 1 if len(rises) else 0) * dt_s, np.flatnonzero(forces)[-1] * dt_s
    print(f"{dt_s * 1e3:g} ms, {deep_m * 1e3:.1f} mm, {forces[0]:.1f} N: falls {falls_s:.3f} s, off {off_s:.3f} s")
    assert falls_s <= PATIENT_STOP_S
    assert off_s + dt_s <= LIFT_OFF_S
    assert max(forces) <= CONTACT_FORCE_N


@pytest.mark.parametrize("stiffness_n_m", [450.0, 20_000.0])
def test_a_finger_leaves_a_place_that_is_higher_than_its_usual_clear_height(stiffness_n_m: float) -> None:
    rig = Pressing(0.002, HEIGHT_HIGH_M - 0.0005, stiffness_n_m)
    rig.press()
    assert rig.tip.force_n > 0.85 * CONTACT_FORCE_N
    for _ in range(round(LIFT_OFF_S / rig.dt_s)):
        rig.step(switch=PRESSED)
    assert rig.tip.force_n <= TOUCHING_N


def test_the_retreat_begins_in_the_tick_of_the_press() -> None:
    rig = Pressing(0.002, 0.0, 800.0)
    rig.press()
    before_m, released = rig.sent[-1]
    assert not released
    rig.step(switch=PRESSED)
    assert rig.sent[-1] == (pytest.approx(before_m + RETREAT_M_S * rig.dt_s), True)


def test_a_press_latches_until_a_person_clears_it_after_the_release() -> None:
    rig = Pressing(0.002, 0.0, 800.0)
    rig.press()
    assert rig.step(switch=PRESSED) == STOPPED
    for _ in range(500):
        before_m = rig.sent[-1][0]
        assert rig.step() == STOPPED
        assert rig.sent[-1][1]
        assert rig.sent[-1][0] == pytest.approx(min(CLEAR_HEIGHT_M, before_m + RETREAT_M_S * rig.dt_s))  # no pause
    rig.gate.clear_fault()
    assert rig.step(switch=PRESSED) == STOPPED
    rig.gate.clear_fault()
    assert rig.step() is None
    assert not rig.sent[-1][1]


def test_a_short_silence_stops_at_once_and_ends_by_itself() -> None:
    rig = Pressing(0.002, 0.0, 800.0)
    rig.press()
    silent = SwitchReading(True, SWITCH_SILENCE_S + 0.001, "")
    for _ in range(3):
        before_m = rig.sent[-1][0]
        assert rig.step(switch=silent) is None
        assert rig.sent[-1] == (pytest.approx(before_m + RETREAT_M_S * rig.dt_s), True)
    assert rig.step() is None
    assert not rig.sent[-1][1]


@pytest.mark.parametrize("code", OF_THE_PATIENT)
def test_the_patients_stop_takes_the_place_of_another_fault_and_the_first_of_its_own_is_kept(code: FaultCode) -> None:
    gate = PatientGate()
    gate.trip(Fault(FaultCode.ENCODER_JUMPED, "index", value=6.0))
    gate.trip(Fault(code, detail="is silent"))
    assert gate.fault == Fault(code, detail="is silent")
    for other in (FaultCode.PATIENT_SWITCH_FAILED, code, FaultCode.ENCODER_JUMPED):
        gate.trip(Fault(other))
        assert gate.fault == Fault(code, detail="is silent")


def test_a_press_takes_the_place_of_a_failed_switch() -> None:
    rig = Pressing(0.002, 0.0, 800.0)
    assert rig.step(switch=SwitchReading(True, 0.0, "sends wrong frames")) == failed("sends wrong frames")
    assert rig.step(switch=PRESSED) == STOPPED
    assert rig.step(switch=SwitchReading(True, 9.0, "")) == STOPPED


def test_without_the_patients_stop_a_retreat_waits() -> None:
    rig = Pressing(0.002, 0.0, 800.0)
    rig.press()
    before_m = rig.sent[-1][0]
    for _ in range(round(STOP_S / rig.dt_s) - 1):
        rig.step(age_s=9.0)
        assert rig.sent[-1] == (before_m, True)
