"""The motor's voltage holds a speed and reaches it in time; judged at the simulated motor."""

import math
from collections import deque
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.signal import find_peaks

from common.buses.serial_messages import MOTOR_MAX_MV, MessageId, TactTipCommand, encode_frame
from common.limits import MOTOR_FLOOR_RPM, MOTOR_MAX_RPM
from operator_site.vibration.motor_drive import MOTOR, RPM_TO_RAD_S, Motor, MotorDrive, motor_mv
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.physics.motor import VibrationMotors

TICK_S = 0.002
ON_THE_WAY = 1
"""Ticks from a command to the motor."""
WITHIN = 0.2
"""Of the felt intensity, which grows with the square of the speed."""


def command(drive: MotorDrive, t_s: float, rpm: float) -> TactTipCommand:
    drive.step(t_s, rpm)
    return TactTipCommand(drive.hold_mv, 0, *drive.pulse)


def frame_of(sent: TactTipCommand) -> bytes:
    return encode_frame(MessageId.TACTTIP_COMMAND, 0, sent.encode())


def driven(wanted_rpm: Callable[[float], float], seconds: float = 0.4, compensated: bool = True) -> np.ndarray:
    """Time, s, and speed, rpm, of the simulated motor behind its module, commanded every 4 ms."""
    motor, drive, module = VibrationMotors(1), MotorDrive(), TactTip(0)
    line, seen = deque([b""] * ON_THE_WAY), []
    for tick in range(round(seconds / TICK_S)):
        t_s, frame = tick * TICK_S, b""
        if tick % 2 == 0:
            rpm = wanted_rpm(t_s)
            frame = frame_of(command(drive, t_s, rpm) if compensated else TactTipCommand(motor_mv(rpm), 0))
        line.append(frame)
        module.feed(line.popleft(), t_s)
        motor.step(TICK_S, np.array([module.motor_v(t_s, t_s + TICK_S)]))
        seen.append((t_s + TICK_S, float(motor.rpm[0])))
    return np.array(seen)


def reached_s(course: np.ndarray, rpm: float) -> float:
    """When the felt intensity first is within WITHIN of that of a speed."""
    near = course[course[:, 1] >= math.sqrt(1.0 - WITHIN) * rpm]
    return float(near[0, 0]) if len(near) else math.inf


def test_voltage_holds_the_speed() -> None:
    assert motor_mv(10_000.0) == pytest.approx(1410, abs=10)
    assert pytest.approx(0.35, abs=0.01) == MOTOR.start_v
    assert pytest.approx(0.05, abs=0.001) == MOTOR.time_constant_s
    assert [motor_mv(v) for v in (0.0, -1.0, math.nan, math.inf)] == [0, 0, 0, 0]
    assert motor_mv(1e9) == motor_mv(MOTOR_MAX_RPM)
    for speed in np.linspace(500.0, 10_000.0, 20):
        omega = 0.0
        for _ in range(2000):  # the motor's own equation, integrated
            current = (motor_mv(speed) / 1000.0 - 6.4e-4 * omega) / 10.8
            omega += (6.4e-4 * current - 2.2e-8 * omega - 2.1e-5) / 3e-9 * 5e-4
        assert omega / RPM_TO_RAD_S == pytest.approx(speed, abs=10.0)


@pytest.mark.parametrize("attack_rpm", [MOTOR_FLOOR_RPM, 5000.0, 7600.0, MOTOR_MAX_RPM])
@pytest.mark.parametrize("decay_per_s", [0.0, 30.0, 40.0])
def test_a_tap_has_its_strength_and_comes_at_least_twice_as_soon(attack_rpm: float, decay_per_s: float) -> None:
    def tap(t_s: float) -> float:
        return attack_rpm * math.exp(-decay_per_s * t_s) if t_s <= 0.15 else 0.0

    course, alone = driven(tap), driven(tap, compensated=False)
    peak = (course[:, 1].max() / attack_rpm) ** 2
    assert abs(peak - 1.0) <= WITHIN
    assert 2.0 * reached_s(course, attack_rpm) <= reached_s(alone, attack_rpm)
    # Alone the motor needs that long even for an attack that does not decay at all.
    assert 2.0 * reached_s(course, attack_rpm) <= reached_s(driven(lambda _: attack_rpm, compensated=False), attack_rpm)


@pytest.mark.parametrize("rate_hz", [2.0, 5.0, 10.0, 15.0])
def test_impulses_are_separate_peaks_of_speed(rate_hz: float) -> None:
    def pattern(t_s: float) -> float:
        crossed = range(math.floor(t_s * rate_hz) + 1)
        return (220.0 + sum(400.0 * math.exp(-60.0 * (t_s - n / rate_hz)) for n in crossed)) / RPM_TO_RAD_S

    course = driven(pattern, seconds=2.0)
    peaks, _ = find_peaks(np.append(course[:, 1], 0.0), prominence=0.3 * course[:, 1].max())
    assert len(peaks) == math.floor(1.999 * rate_hz) + 1
    # A peak has the height that was asked for when the next command went out, up to 4 ms after the groove.
    asked = (220.0 + 400.0 * math.exp(-60.0 * 0.004)) / RPM_TO_RAD_S
    assert course[peaks, 1].min() >= math.sqrt(1.0 - WITHIN) * asked
    assert course[peaks, 1].max() <= 620.0 / RPM_TO_RAD_S


def test_an_even_speed_is_held_with_an_even_voltage() -> None:
    drive = MotorDrive()
    sent = [command(drive, 0.004 * n, 5000.0) for n in range(100)]
    assert sent[0].pulse_mv == MOTOR_MAX_MV
    assert {each.pulse_number for each in sent[:3]} == {sent[0].pulse_number}
    assert sent[20:] == [TactTipCommand(motor_mv(5000.0), 0)] * 80


@pytest.mark.parametrize("late_s", [0.004, 0.02, 0.05, 0.09])
def test_a_host_that_stands_still_in_a_pulse_neither_prolongs_nor_repeats_it(late_s: float) -> None:
    """The module times the pulse: a motor does not run away because the next command is late."""
    motor, drive, module, fastest = VibrationMotors(1), MotorDrive(), TactTip(0), 0.0
    command_s = [0.0, 0.004, 0.004 + late_s, *(0.008 + late_s + 0.004 * n for n in range(30))]
    for tick in range(round(0.2 / 0.001)):
        t_s = 0.001 * tick
        while command_s and command_s[0] <= t_s:
            module.feed(frame_of(command(drive, command_s.pop(0), MOTOR_MAX_RPM)), t_s)
        motor.step(0.001, np.array([module.motor_v(t_s, t_s + 0.001)]))
        fastest = max(fastest, float(motor.rpm[0]))
    assert 0.94 * MOTOR_MAX_RPM <= fastest <= MOTOR_MAX_RPM * 1.001


def test_a_hand_that_trembles_makes_no_impulses() -> None:
    """Speeds that rise and fall a little are followed, not held at their tops."""
    drive, mean = MotorDrive(), []
    for n in range(500):
        drive.step(0.004 * n, 4000.0 + 150.0 * math.sin(0.9 * n))
        mean.append(drive.speed_rad_s / RPM_TO_RAD_S)
    assert np.mean(mean[100:]) == pytest.approx(4000.0, rel=0.02)


@pytest.mark.parametrize(
    "real",
    [
        Motor(inertia_kg_m2=2.4e-9),
        Motor(inertia_kg_m2=3.6e-9),
        Motor(resistance_ohm=9.2),
        Motor(resistance_ohm=12.4),
        Motor(friction_n_m=3.0e-5),
    ],
)
def test_a_motor_with_other_constants_is_neither_late_nor_wild(real: Motor) -> None:
    """A fifth more or less: within three fifths of the intensity on the way, and no worse than alone in the end."""
    drive, module, speed, course = MotorDrive(), TactTip(0), 0.0, []
    for n in range(400):
        t_s = 0.001 * n
        if n % 4 == 0:
            module.feed(frame_of(command(drive, t_s, 6000.0)), t_s)
        speed = real.speed_rad_s(speed, module.motor_v(t_s, t_s + 0.001), 0.001)
        course.append(speed / RPM_TO_RAD_S)
    alone = (1e-3 * motor_mv(6000.0) - real.start_v) / (real.voltage_v(1.0) - real.start_v) / RPM_TO_RAD_S
    assert course[-1] == pytest.approx(alone, rel=0.01)
    assert max(course) < 1.25 * 6000.0
    assert max(course[:25]) > 0.75 * 6000.0


@given(
    st.lists(
        st.tuples(
            st.floats(-0.1, 1.0) | st.sampled_from([math.nan, math.inf]),
            st.floats(allow_nan=True, allow_infinity=True),
        )
    )
)
@example([(0.0, 1.0), (-0.0625, 1.0), (0.0625, 0.0)])  # a clock that is set back in a pulse
def test_any_speed_gives_a_valid_voltage_and_no_speed_gives_none(
    steps: list[tuple[float, float]],
) -> None:
    drive, t_s = MotorDrive(), 0.0
    for since_s, rpm in steps:
        t_s += since_s
        sent = command(drive, t_s, rpm)
        sent.encode()  # raises if a value is out of range
        assert rpm > 0.0 or (sent.motor_mv, sent.pulse_us) == (0, 0)
        assert drive.speed_rad_s <= 1.05 * MOTOR_MAX_RPM * RPM_TO_RAD_S


def test_after_silence_the_motor_is_taken_to_stand_still() -> None:
    """Longer than the module waits for a command: it has switched its motor off by itself."""
    drive = MotorDrive()
    for n in range(50):
        drive.step(0.004 * n, 8000.0)
    assert drive.speed_rad_s > 800.0
    assert command(drive, 5.0, 8000.0).pulse_mv == MOTOR_MAX_MV
    assert drive.speed_rad_s == 0.0
