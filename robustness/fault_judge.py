"""Judges the effect of each fault from recordings of the simulated devices. Pure: recorded arrays in, findings out."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.limits import (
    FORCE_RAMP_UP_N_S,
    FORCE_SAFE_S,
    GAP_S,
    LIFT_OFF_S,
    MOTOR_FLOOR_RPM,
    MOTOR_SAFE_S,
    MOTOR_STILL_S,
    PATIENT_STOP_S,
    PLATE_PEAK_C,
    SENSOR_PLATE_C,
    THERMAL_SAFE_S,
)
from robustness.fault_table import AT_FINGERS, STROKING, Actuator, Fault, Outcome

Floats = NDArray[np.float64]

LOG_S = 0.010
"""Interval between entries of the truth logs, s."""
TICK_S = 0.010
"""Largest time by which the stamp of a latch may precede its fault, s: a site stamps its notes with the start of the
tick."""
GRANTED_S = 2.0 * LOG_S
"""Time that logging adds to a measured time, s: one entry before and one after. Only a pause of the machine adds
more."""
HAND_STOP_S = 2.0 * GAP_S
"""Time from the last motion packet until the remote hand stands still along the bench, s."""
STILL_M_S = 0.010
RISE_N = 0.01
"""Least rise of the contact force between two entries that counts, N."""
FELT_N = 0.15
"""Least force that counts as felt, N."""
WINDOW_S = 0.5
HOLD_S = {
    Actuator.FORCE: FORCE_SAFE_S,
    Actuator.MOTOR: MOTOR_SAFE_S,
    Actuator.PELTIER: THERMAL_SAFE_S,
    Actuator.HEATER: THERMAL_SAFE_S,
    Actuator.HAND: HAND_STOP_S,
}


@dataclass(frozen=True, slots=True)
class Truth:
    """Recorded behaviour of the simulated devices: times (n,), s, and values (n, 5) of each finger.

    Attributes:
        finger_s, force_n, motor_mv, motor_rpm, peltier, plate_c: at the operator's fingers.
        patient_s, heater, sensor_plate_c, hand_x_m (n,), hand_z_m, contact_n: at the remote hand.
        faults: times at which a site latched a fault, s, with its text.
        ticks_s: times of each process's ticks, s; a process cannot act between two of them.
    """

    finger_s: Floats
    force_n: Floats
    motor_mv: Floats
    motor_rpm: Floats
    peltier: Floats
    plate_c: Floats
    patient_s: Floats
    heater: Floats
    sensor_plate_c: Floats
    hand_x_m: Floats
    hand_z_m: Floats
    contact_n: Floats
    faults: list[tuple[float, str]]
    ticks_s: dict[str, Floats]

    def pause_s(self, begin_s: float, end_s: float, without: str = "") -> float:
        """Longest time between two ticks of any process other than `without`, s."""
        longest_s = 0.0
        for name, ticks_s in self.ticks_s.items():
            then = ticks_s[(ticks_s >= begin_s) & (ticks_s <= end_s)]
            if name != without and len(then) > 1:
                longest_s = max(longest_s, float(np.diff(then).max()))
        return longest_s


@dataclass(frozen=True, slots=True)
class Done:
    """A fault that was injected, with its times.

    Attributes:
        begin_s, end_s: when it began, and when it was over or mended.
        cleared_s: when a person cleared it and engaged; None where that was not needed.
        next_s: end of the time that belongs to this fault.
    """

    fault: Fault
    begin_s: float
    end_s: float
    next_s: float
    cleared_s: float | None = None

    @property
    def over_s(self) -> float:
        """Time from which the session must work again, s."""
        return self.end_s if self.cleared_s is None else self.cleared_s


@dataclass(slots=True)
class Finding:
    """Result of one fault."""

    fault: Fault
    outcome: Outcome | None
    """None where none of the three outcomes occurred: the session never worked again."""
    safe_s: dict[Actuator, float] = field(default_factory=dict)
    """Time from the fault, or from its detection or latch, until each actuator stayed neutral, s."""
    latched_s: float | None = None
    """Time from the fault to the latch, s."""
    latched_by: str = ""
    leaves_s: dict[str, float] = field(default_factory=dict)
    """Time from the patient's stop until the contact force falls, and until the finger is off the patient, s."""
    resumed_s: float | None = None
    """Time from the end of the fault, or from engaging again, until force and vibration were felt, s."""
    wrong: list[str] = field(default_factory=list)
    """Deviations from the table; empty when everything is as required."""
    paused_s: float = 0.0
    """Longest pause of a process that no fault asked for, s: the machine was busy with other work."""

    @property
    def granted_s(self) -> float:
        """Time by which a hold time may be exceeded, s."""
        return GRANTED_S + self.paused_s


def judge(done: Done, truth: Truth) -> Finding:
    """Determine the effect of a fault, and compare it with the table."""
    fault = done.fault
    latch = next(((t, words) for t, words in truth.faults if done.begin_s - TICK_S <= t < done.next_s), None)
    finding = Finding(fault, None)
    if latch is not None:
        finding.latched_s, finding.latched_by = max(0.0, latch[0] - done.begin_s), latch[1]
    finding.paused_s = truth.pause_s(done.begin_s - 0.1, done.end_s + 0.1, fault.where)
    since_s = done.begin_s + fault.noticed_s
    if latch is not None and fault.expected is Outcome.LATCHED:
        since_s = latch[0]
        if finding.latched_s is not None and finding.latched_s > fault.later_s:
            finding.wrong.append(f"latched after {finding.latched_s:.2f} s only")
    for actuator in Actuator:
        if actuator in fault.neutral and done.over_s - since_s > HOLD_S[actuator] + finding.granted_s:
            _judge_neutral(finding, truth, actuator, since_s, done.over_s)
    if fault.leaves:
        _judge_leaving(finding, truth, done.begin_s + fault.noticed_s, done.over_s)
    again_s = _felt_again(truth, done.over_s, done.next_s)
    finding.resumed_s = None if again_s is None else again_s - done.over_s
    finding.outcome = _outcome(done, truth, latch is not None, again_s, finding.granted_s)
    # A better outcome than required is right, unless something had to be neutral. A pause of the machine acts as a gap.
    better = (
        fault.expected is Outcome.RESUMES and finding.outcome is Outcome.CONTINUES and not fault.neutral & AT_FINGERS
    )
    paused = (
        fault.expected is Outcome.CONTINUES and finding.outcome is Outcome.RESUMES and finding.paused_s > GAP_S / 2.0
    )
    if finding.outcome is not fault.expected and not better and not paused:
        finding.wrong.append(finding.outcome.value if finding.outcome else _afterwards(done, truth))
    _judge_ramp(finding, truth, again_s)
    _judge_temperatures(finding, truth, done)
    return finding


def _judge_neutral(finding: Finding, truth: Truth, actuator: Actuator, since_s: float, until_s: float) -> None:
    time_s, active = _active(truth, actuator, finding.fault)
    during = (time_s > since_s) & (time_s < until_s)
    if not during.any():
        finding.wrong.append(f"{actuator.value}: nothing was recorded")
        return
    still = time_s[during & active]
    safe_s = max(0.0, float(still[-1]) - since_s) if len(still) else 0.0
    finding.safe_s[actuator] = safe_s
    if safe_s > HOLD_S[actuator] + finding.granted_s:
        finding.wrong.append(f"{actuator.value} neutral after {safe_s * 1e3:.0f} ms only")
    if actuator is Actuator.MOTOR:
        fast = truth.finger_s[during & _any(truth.motor_rpm >= MOTOR_FLOOR_RPM, finding.fault)]
        if len(fast) and fast[-1] - since_s > MOTOR_STILL_S + finding.granted_s:
            finding.wrong.append(f"motor still felt after {(fast[-1] - since_s) * 1e3:.0f} ms")


def _judge_leaving(finding: Finding, truth: Truth, since_s: float, until_s: float) -> None:
    """Measure how soon the contact force of the stroking finger falls for good, and when the finger is off."""
    then = (truth.patient_s > since_s) & (truth.patient_s < until_s)
    time_s, force_n = truth.patient_s[then], truth.contact_n[then, FINGERS.index(STROKING)]
    rising = np.flatnonzero(np.diff(force_n) > RISE_N) + 1
    touching = np.flatnonzero(force_n > 0.0)
    ends = {"falls": (rising, PATIENT_STOP_S), "off": (touching, LIFT_OFF_S)}
    for name, (entries, most_s) in ends.items():
        if not len(touching):
            finding.wrong.append("no contact at the patient's stop")
            return
        last_s = float(time_s[entries[-1]]) - since_s if len(entries) else 0.0
        finding.leaves_s[name] = last_s
        if last_s > most_s + finding.granted_s:
            finding.wrong.append(f"contact force {name} after {last_s * 1e3:.0f} ms only")


def _any(active: NDArray[np.bool_], fault: Fault) -> NDArray[np.bool_]:
    """Whether any finger that counts for a fault is active, (n,) from (n, 5)."""
    counting = slice(None) if fault.finger is None else [FINGERS.index(fault.finger)]
    return np.asarray(active[:, counting].any(axis=1))


def _active(truth: Truth, actuator: Actuator, fault: Fault) -> tuple[Floats, NDArray[np.bool_]]:
    match actuator:
        case Actuator.FORCE:
            return truth.finger_s, _any(truth.force_n > 0.0, fault)
        case Actuator.MOTOR:
            return truth.finger_s, _any(truth.motor_mv > 0.0, fault)
        case Actuator.PELTIER:
            return truth.finger_s, _any(truth.peltier != 0.0, fault)
        case Actuator.HEATER:
            return truth.patient_s, _any(truth.heater != 0.0, fault)
        case Actuator.HAND:
            # Backward difference: a forward one would count motion after the fault as part of it.
            dt_s = np.diff(truth.patient_s)
            speed = np.abs(np.diff(truth.hand_x_m)) / dt_s
            rise = np.diff(truth.hand_z_m, axis=0) / dt_s[:, None]
            return truth.patient_s, np.append(False, (speed > STILL_M_S) | (rise < -STILL_M_S).any(axis=1))


def _felt(truth: Truth) -> NDArray[np.bool_]:
    """Whether the stroking finger felt force and vibration, (n,)."""
    finger = FINGERS.index(STROKING)
    return np.asarray((truth.force_n[:, finger] > FELT_N) & (truth.motor_mv[:, finger] > 0.0))


def _afterwards(done: Done, truth: Truth) -> str:
    """Describe what the stroking finger felt after the session should have worked again."""
    then = (truth.finger_s >= done.over_s) & (truth.finger_s < done.next_s)
    if not then.any():
        return "never worked again: nothing was recorded"
    finger = FINGERS.index(STROKING)
    force_n, vibrated = truth.force_n[then, finger], truth.motor_mv[then, finger] > 0.0
    return f"never worked again: {force_n.max():.2f} N at most, vibration {vibrated.mean():.0%} of the time"


def _felt_again(truth: Truth, since_s: float, until_s: float) -> float | None:
    felt = (truth.finger_s >= since_s) & (truth.finger_s < until_s) & _felt(truth)
    return float(truth.finger_s[felt][0]) if felt.any() else None


def _outcome(done: Done, truth: Truth, latched: bool, again_s: float | None, granted_s: float) -> Outcome | None:
    if latched:
        before = done.cleared_s if done.cleared_s is not None else done.next_s
        settled_s = done.end_s + FORCE_SAFE_S + granted_s
        between = (truth.finger_s > settled_s) & (truth.finger_s < before)
        quiet = not (truth.force_n[between] > 0.0).any() and not (truth.motor_mv[between] > 0.0).any()
        return Outcome.LATCHED if quiet and again_s is not None else None
    if again_s is None:
        return None
    return Outcome.CONTINUES if _felt_throughout(truth, done.begin_s, done.end_s) else Outcome.RESUMES


def _felt_throughout(truth: Truth, begin_s: float, end_s: float) -> bool:
    """Whether force was felt in every half second of the fault."""
    edges = np.arange(begin_s, max(end_s, begin_s + WINDOW_S) + 1e-9, WINDOW_S)
    felt_s = truth.finger_s[truth.force_n[:, FINGERS.index(STROKING)] > FELT_N]
    return all(((felt_s >= a) & (felt_s < a + WINDOW_S)).any() for a in edges[:-1])


def _judge_ramp(finding: Finding, truth: Truth, again_s: float | None) -> None:
    """Check that force came back from zero as a ramp."""
    if again_s is None or finding.outcome is Outcome.CONTINUES:
        return
    after = (truth.finger_s > again_s - 0.2) & (truth.finger_s < again_s + 0.3)
    force_n, time_s = truth.force_n[after, FINGERS.index(STROKING)], truth.finger_s[after]
    zero = np.flatnonzero(force_n == 0.0)
    if not len(zero) or zero[-1] + 1 >= len(force_n):
        return
    start_s = time_s[zero[-1]]
    over = force_n[zero[-1] + 1 :] - FORCE_RAMP_UP_N_S * (time_s[zero[-1] + 1 :] - start_s + finding.granted_s)
    if over.max() > 0.0:
        finding.wrong.append(f"force came back {over.max():.1f} N above its ramp")


def _judge_temperatures(finding: Finding, truth: Truth, done: Done) -> None:
    """Check that no plate exceeded its limit, whatever failed."""
    for name, time_s, plate_c, most_c in (
        ("operator's plate", truth.finger_s, truth.plate_c, PLATE_PEAK_C),
        ("sensor's plate", truth.patient_s, truth.sensor_plate_c, SENSOR_PLATE_C),
    ):
        then = (time_s >= done.begin_s) & (time_s < done.next_s)
        if not then.any():
            finding.wrong.append(f"{name}: nothing was recorded")
        elif not plate_c[then].max() <= most_c:
            finding.wrong.append(f"{name} at {plate_c[then].max():.2f} C")
