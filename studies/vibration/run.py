"""Vibration rendering: the motor uncompensated, compensated, started early, and at its physical limit.

All results are measured at the simulated motor. A tick lasts 2 ms, commands come at most every 4 ms, and the line
delays them by 2 ms. The felt intensity is taken as the square of the motor's speed. The limit is a drive that knows the
motor's true speed every millisecond.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from common.buses.serial_messages import MessageId, TactTipCommand, encode_frame
from common.limits import MOTOR_MAX_RPM
from common.wire.messages import Event, EventKind, ExplorationMode
from operator_site.vibration.motor_drive import FULL_V, MOTOR, RPM_TO_RAD_S, MotorDrive, motor_mv
from operator_site.vibration.vibration import SHOWN, FingerVibration, IntensityScale, Surface
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.physics.motor import VibrationMotors
from studies.compared import Compared
from studies.pieces import HERE, Piece, Work, rows_of
from studies.running import Progress, tables_of

Floats = NDArray[np.float64]

TICK_S = 0.002
COMMAND_TICKS = 2
LINE_TICKS = 1
CONTACT_S = 0.1
TAP_SECONDS = 0.4
NEAR = 0.2
"""Relative error of intensity within which the wanted intensity counts as reached."""
PLASTIC = Surface(k_tap=4000.0, b_tap_per_s=30.0, k_stroke_v=2000.0, k_stroke_f=60.0, b_groove_per_s=60.0)
ATTACKS_RPM = (3300.0, 4000.0, 5000.0, 6000.0, 7000.0, 8000.0, 9000.0, MOTOR_MAX_RPM)
SHOWN_ATTACK_RPM = 7000.0
RATES_HZ = (2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 15.0, 18.0, 22.0, 25.0, 30.0, 40.0)
GROOVE_RAD_S = 400.0
STROKE_M_S, STROKE_N = 0.05, 2.0
ALONE, COMPENSATED, EARLY, LIMIT = "alone", "compensated", "started early", "limit"
OTHERS = {
    "as modelled": MOTOR,
    "inertia -20 %": replace(MOTOR, inertia_kg_m2=0.8 * MOTOR.inertia_kg_m2),
    "inertia +20 %": replace(MOTOR, inertia_kg_m2=1.2 * MOTOR.inertia_kg_m2),
    "resistance -15 %": replace(MOTOR, resistance_ohm=0.85 * MOTOR.resistance_ohm),
    "resistance +15 %": replace(MOTOR, resistance_ohm=1.15 * MOTOR.resistance_ohm),
    "friction +40 %": replace(MOTOR, friction_n_m=1.4 * MOTOR.friction_n_m),
}
tables = tables_of("taps", "impulses", "scales", "motors")
COMPARED = (
    Compared("taps", "peak_intensity_share", "more", ("attack_rpm", "way"), absolute=0.01),
    Compared("taps", "near_after_s", "less", ("attack_rpm", "way"), absolute=TICK_S),
    Compared("motors", "end_intensity_share", "same", ("motor",), absolute=0.01),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Run all parts; `seed` has no effect, because nothing is random."""
    del seed
    every = 3 if quick else 1
    pieces: dict[str, list[Piece]] = {
        "taps": [(_taps, (attack_rpm,)) for attack_rpm in ATTACKS_RPM[::every]],
        "courses": [(_courses, ())],
        "impulses": [(_impulses, (rate_hz,)) for rate_hz in RATES_HZ[::every]],
        "scales": [(_scales, ())],
        "motors": [(_motors, ())],
    }
    return rows_of(pieces, work, progress)


def _tapped(attack_rpm: float, known: bool = False) -> Floats:
    """Return the speed wanted by rendering at each tick, rpm, with contact at CONTACT_S, known ahead or not."""
    finger, asked = FingerVibration(), []
    approach = attack_rpm * RPM_TO_RAD_S / PLASTIC.k_tap
    first = round(CONTACT_S / TICK_S)
    for tick in range(round(TAP_SECONDS / TICK_S)):
        touching = tick >= first
        asked.append(
            finger.step(
                tick * TICK_S,
                ExplorationMode.TAPPING if touching else ExplorationMode.FREE,
                0.0,
                1.0,
                surface=PLASTIC,
                events=[Event(1, EventKind.TAP, 0, 0, 0, approach)] if tick == first else [],
                contact_in_s=max(0.0, CONTACT_S - tick * TICK_S) if known else math.inf,
                approach_m_s=approach,
            )
        )
    return np.array(asked)


def _commanded(asked_rpm: Floats, command: Callable[[float, float], TactTipCommand]) -> Floats:
    """Return the mean voltage at the motor in each tick, V.

    At most one command goes out in COMMAND_TICKS; switching on or off goes out at once.
    """
    module, volts, sent, on = TactTip(0), [], -COMMAND_TICKS, False
    line = deque([b""] * LINE_TICKS)
    for tick, rpm in enumerate(asked_rpm.tolist()):
        frame, now_s = b"", tick * TICK_S
        if tick - sent >= COMMAND_TICKS or (rpm > 0.0) != on:
            sent, on = tick, rpm > 0.0
            frame = encode_frame(MessageId.TACTTIP_COMMAND, tick & 0xFF, command(now_s, rpm).encode())
        line.append(frame)
        module.feed(line.popleft(), now_s)
        volts.append(module.motor_v(now_s, now_s + TICK_S))
    return np.array(volts)


def _held(_: float, rpm: float) -> TactTipCommand:
    """Return a command of only the voltage that holds a speed."""
    return TactTipCommand(motor_mv(rpm), 0)


def _compensated() -> Callable[[float, float], TactTipCommand]:
    """Return the commands of a new drive."""
    drive = MotorDrive()

    def command(now_s: float, rpm: float) -> TactTipCommand:
        drive.step(now_s, rpm)
        return TactTipCommand(drive.hold_mv, 0, *drive.pulse)

    return command


def _turning(volts: Floats) -> Floats:
    """Return the speed of the simulated motor after each tick, rpm."""
    motor, speeds = VibrationMotors(1), []
    for each in volts:
        motor.step(TICK_S, np.array([each]))
        speeds.append(float(motor.rpm[0]))
    return np.array(speeds)


def _at_most(attack_rpm: float) -> Floats:
    """Return the fastest speeds that the drive allows, rpm: full voltage to the attack, then at most Eq. 1."""
    motor, reached, speeds, part = VibrationMotors(1), None, [], 2
    for step in range(round(TAP_SECONDS / TICK_S) * part):
        t_s = step * TICK_S / part - CONTACT_S
        wanted = 0.0
        if 0.0 <= t_s <= 0.15:
            wanted = attack_rpm if reached is None else attack_rpm * math.exp(-PLASTIC.b_tap_per_s * t_s)
        # Full voltage for the part of the step that reaches the wanted speed, then its holding voltage.
        needed = MOTOR.rise_s(wanted * RPM_TO_RAD_S) - MOTOR.rise_s(float(motor.rpm[0]) * RPM_TO_RAD_S)
        share = min(1.0, max(0.0, needed / (TICK_S / part)))
        motor.step(share * TICK_S / part + 1e-9, np.array([FULL_V]))
        motor.step((1.0 - share) * TICK_S / part + 1e-9, np.array([MOTOR.voltage_v(wanted * RPM_TO_RAD_S)]))
        if reached is None and wanted and motor.rpm[0] >= 0.99 * attack_rpm:
            reached = t_s
        if step % part == part - 1:
            speeds.append(float(motor.rpm[0]))
    return np.array(speeds)


def _ways(attack_rpm: float) -> dict[str, tuple[Floats, Floats]]:
    """Return the wanted and the reached speeds of each way to render a tap, rpm."""
    asked, early = _tapped(attack_rpm), _tapped(attack_rpm, known=True)
    return {
        ALONE: (asked, _turning(_commanded(asked, _held))),
        COMPENSATED: (asked, _turning(_commanded(asked, _compensated()))),
        EARLY: (early, _turning(_commanded(early, _compensated()))),
        LIMIT: (asked, _at_most(attack_rpm)),
    }


def _taps(attack_rpm: float) -> Iterator[dict[str, Any]]:
    after_s = TICK_S * (np.arange(round(TAP_SECONDS / TICK_S)) + 1) - CONTACT_S
    for way, (_, speed) in _ways(attack_rpm).items():
        intensity = (speed / attack_rpm) ** 2
        near = after_s[intensity >= 1.0 - NEAR]
        yield {
            "attack_rpm": attack_rpm,
            "way": way,
            "peak_intensity_share": float(intensity.max()),
            "near_after_s": float(near[0]) if len(near) else None,
        }


def _courses() -> Iterator[dict[str, Any]]:
    for way, (asked, speed) in _ways(SHOWN_ATTACK_RPM).items():
        yield {"way": way, "tick_s": TICK_S, "contact_s": CONTACT_S, "asked": asked.tolist(), "speed": speed.tolist()}


def _impulses(rate_hz: float) -> Iterator[dict[str, Any]]:
    """Yield the dip of the speed between the grooves of a stroke, relative to its maximum."""
    ticks = round(2.0 / TICK_S)
    finger, folding, plain, crossed = FingerVibration(), [], [], 0
    for tick in range(ticks):
        t_s, events = tick * TICK_S, []
        while crossed / rate_hz <= t_s + 1e-9:
            events.append(Event(crossed + 1, EventKind.GROOVE, 0, round(1e9 * crossed / rate_hz), 0, GROOVE_RAD_S))
            crossed += 1
        rpm = finger.step(t_s, ExplorationMode.STROKING, STROKE_M_S, STROKE_N, surface=PLASTIC, events=events)
        folding.append(rpm)
        left = sum(math.exp(-PLASTIC.b_groove_per_s * (t_s - n / rate_hz)) for n in range(crossed))
        bias = PLASTIC.k_stroke_v * STROKE_M_S + PLASTIC.k_stroke_f * STROKE_N
        plain.append(min(MOTOR_MAX_RPM, (bias + GROOVE_RAD_S * left) / RPM_TO_RAD_S))
    shown = {
        "asked": np.array(plain),
        ALONE: _turning(_commanded(np.array(plain), _held)),
        COMPENSATED: _turning(_commanded(np.array(plain), _compensated())),
        "rendered": _turning(_commanded(np.array(folding), _compensated())),
    }
    for way, speed in shown.items():
        late = speed[ticks // 2 :]
        yield {
            "rate_hz": rate_hz,
            "way": way,
            "depth": float((late.max() - late.min()) / late.max()),
            "mean_rpm": float(late.mean()),
        }


def _scales() -> Iterator[dict[str, Any]]:
    """Yield the felt intensity against the intensity of Eq. 1 and 2, both relative to the largest."""
    for scale in SHOWN:
        for asked in np.linspace(0.0, 1.0, 101):
            speed = IntensityScale(scale).rpm(float(asked) * MOTOR_MAX_RPM)
            yield {"scale": scale, "asked_share": float(asked), "felt_share": (speed / MOTOR_MAX_RPM) ** 2}


def _motors() -> Iterator[dict[str, Any]]:
    """Yield the results of motors that deviate from the drive's model, at one attack without decay."""
    asked = np.full(round(0.3 / TICK_S), SHOWN_ATTACK_RPM)
    for name, real in OTHERS.items():
        volts = _commanded(asked, _compensated())
        speed, course = 0.0, []
        for each in volts:
            speed = real.speed_rad_s(speed, float(each), TICK_S)
            course.append(speed / RPM_TO_RAD_S / SHOWN_ATTACK_RPM)
        intensity = np.array(course) ** 2
        near = np.flatnonzero(intensity >= (1.0 - NEAR) * intensity[-1])
        yield {
            "motor": name,
            "end_intensity_share": float(intensity[-1]),
            "largest_intensity_share": float(intensity.max()),
            "near_its_end_after_s": TICK_S * float(near[0] + 1),
        }
