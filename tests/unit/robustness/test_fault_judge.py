"""The judge of faults finds wrong and right courses in synthetic truth."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from common.fingers import FINGERS
from common.limits import FORCE_SAFE_S, LIFT_OFF_S, PATIENT_STOP_S, PLATE_PEAK_C, SENSOR_PLATE_C
from robustness.fault_judge import HAND_STOP_S, LOG_S, STILL_M_S, TICK_S, Done, Finding, Floats, Truth, judge
from robustness.fault_table import ALL, STROKING, Actuator, Fault, Outcome

FINGER = FINGERS.index(STROKING)
BEGIN_S, END_S, NEXT_S = 10.0, 13.0, 16.0
STOPPED = Fault("remote stopped for 3 s", "remote", "stop", Outcome.RESUMES, ALL, seconds=3.0)
LATCHED = Fault("heater stuck", "sim-remote", "stuck", Outcome.LATCHED, ALL, seconds=0.0, later_s=2.0)
DONE = Done(STOPPED, BEGIN_S, END_S, NEXT_S)
times_s = np.arange(8.0, NEXT_S, LOG_S)


def five(values: Floats) -> Floats:
    each = np.zeros((len(values), len(FINGERS)))
    each[:, FINGER] = values
    return each


def stroking(quiet_s: float, again_s: float) -> Truth:
    """A stroke that is neutral from one time on, and felt again, with a ramp, from another."""
    works = (times_s < quiet_s) | (times_s >= again_s)
    force_n = np.where(times_s < quiet_s, 1.0, np.clip(50.0 * (times_s - again_s), 0.0, 1.0))
    x_m = np.cumsum(np.where(works, 0.05 * LOG_S, 0.0))
    return Truth(
        finger_s=times_s,
        force_n=five(force_n),
        motor_mv=five(np.where(works, 1000.0, 0.0)),
        motor_rpm=five(np.where(works, 5000.0, 0.0)),
        peltier=five(np.where(works, 0.2, 0.0)),
        plate_c=np.full((len(times_s), 5), 33.0),
        patient_s=times_s,
        heater=five(np.where(works, 0.2, 0.0)),
        sensor_plate_c=np.full((len(times_s), 5), 33.0),
        hand_x_m=x_m,
        hand_z_m=np.zeros((len(times_s), 5)),
        contact_n=np.zeros((len(times_s), 5)),
        faults=[],
        ticks_s={},
    )


def judged(change: Callable[[Truth], Truth] = lambda truth: truth) -> Finding:
    return judge(DONE, change(stroking(BEGIN_S + 0.1, END_S + 0.2)))


def at(time_s: float) -> int:
    return int(np.searchsorted(times_s, time_s - 1e-9))


def with_entry(values: Floats, time_s: float, value: float) -> Floats:
    changed = values.copy()
    changed[at(time_s), FINGER] = value
    return changed


def test_neutral_in_time_and_a_return_by_ramp_are_right() -> None:
    finding = judged()
    assert (finding.outcome, finding.wrong) == (Outcome.RESUMES, [])
    assert finding.safe_s == pytest.approx(dict.fromkeys(Actuator, 0.09), abs=0.011)
    assert finding.resumed_s == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize("before_s", [LOG_S, 0.5, 2.0])
@pytest.mark.parametrize("name", ["force_n", "motor_mv", "peltier", "heater"])
def test_one_entry_of_a_drive_is_found_to_the_very_end(name: str, before_s: float) -> None:
    finding = judged(lambda truth: replace(truth, **{name: with_entry(getattr(truth, name), END_S - before_s, 0.3)}))
    assert len(finding.wrong) == 1
    assert "neutral after" in finding.wrong[0]


@pytest.mark.parametrize("before_s", [LOG_S, 0.5, 2.0])
def test_a_hand_that_moves_or_sinks_is_found_to_the_very_end(before_s: float) -> None:
    def wrong(name: str, metres: float) -> list[str]:
        since = at(END_S - before_s) <= np.arange(len(times_s))
        return judged(
            lambda truth: replace(truth, **{name: (getattr(truth, name).T + np.where(since, metres, 0.0)).T})
        ).wrong

    step_m = 1.01 * STILL_M_S * LOG_S
    for name in ("hand_x_m", "hand_z_m"):
        assert "remote hand neutral after" in wrong(name, -step_m)[0]
        assert wrong(name, -0.9 * step_m) == []
    assert wrong("hand_z_m", 10 * step_m) == []  # rising is its safe state


def test_events_at_or_after_the_end_do_not_count() -> None:
    for again_s in (END_S, END_S + LOG_S):
        finding = judge(DONE, stroking(BEGIN_S + 0.1, again_s))
        assert finding.wrong == []


def test_neutral_too_late_is_wrong_and_a_pause_of_the_machine_is_allowed() -> None:
    late = stroking(BEGIN_S + HAND_STOP_S + 0.1, END_S + 0.2)
    assert len(judge(DONE, late).wrong) == 6, "the motor counts twice: driven and felt"
    paused = np.append(np.arange(8.0, 11.0, LOG_S), np.arange(11.2, NEXT_S, LOG_S))
    finding = judge(DONE, replace(late, ticks_s={"operator": paused}))
    assert (finding.wrong, finding.paused_s) == ([], pytest.approx(0.2, abs=0.02))
    assert len(judge(DONE, replace(late, ticks_s={"remote": paused})).wrong) == 6, "who is stopped is not paused"


def test_force_that_comes_back_at_once_is_wrong() -> None:
    jump = np.where(times_s >= END_S + 0.2, 2.0, 0.0) + np.where(times_s < BEGIN_S + 0.1, 1.0, 0.0)
    assert "above its ramp" in judged(lambda truth: replace(truth, force_n=five(jump))).wrong[0]


def test_no_return_to_work_or_forbidden_work_is_wrong() -> None:
    wrong = judge(DONE, stroking(BEGIN_S + 0.1, NEXT_S)).wrong
    assert "never worked again: 0.00 N at most, vibration 0% of the time" in wrong
    assert "continues" in judge(DONE, stroking(NEXT_S, NEXT_S)).wrong


def test_a_latched_fault_is_neutral_until_it_is_cleared() -> None:
    cleared_s = END_S + 1.0
    done = Done(LATCHED, BEGIN_S, END_S, NEXT_S, cleared_s)
    truth = replace(stroking(BEGIN_S + 0.6, cleared_s + 0.2), faults=[(BEGIN_S + 0.5, "stuck")])
    finding = judge(done, truth)
    assert (finding.outcome, finding.wrong, finding.latched_by) == (Outcome.LATCHED, [], "stuck")
    assert judge(done, replace(truth, faults=[(BEGIN_S + 2.1, "stuck")])).wrong[0] == "latched after 2.10 s only"
    assert judge(done, replace(truth, faults=[])).outcome is Outcome.RESUMES
    at_once = judge(done, replace(truth, faults=[(BEGIN_S - 0.5 * TICK_S, "noted in a tick that began before")]))
    assert (at_once.outcome, at_once.latched_s) == (Outcome.LATCHED, 0.0)
    slipped = replace(truth, force_n=with_entry(truth.force_n, END_S + FORCE_SAFE_S + 0.5, 0.2))
    assert judge(done, slipped).wrong


def test_a_contact_force_that_falls_or_ends_too_late_after_the_patients_stop_is_wrong() -> None:
    cleared_s = END_S + 1.0
    done = Done(replace(LATCHED, leaves=True), BEGIN_S, END_S, NEXT_S, cleared_s)
    truth = replace(stroking(BEGIN_S + 0.05, cleared_s + 0.2), faults=[(BEGIN_S, "patient stopped")])

    def left(falls_s: float, off_s: float) -> Finding:
        """Judge a contact force that rises until one time after the stop, and is gone at another, s."""
        since_s = times_s - BEGIN_S
        force_n = np.interp(since_s, (-2.0, falls_s, off_s), (0.0, 4.0, 0.0))
        return judge(done, replace(truth, contact_n=five(force_n)))

    good = left(0.05, 0.5)
    assert (good.outcome, good.wrong) == (Outcome.LATCHED, [])
    assert good.leaves_s == pytest.approx({"falls": 0.05, "off": 0.5}, abs=1.5 * LOG_S)
    (late,) = left(PATIENT_STOP_S + 0.05, 0.5).wrong
    assert late.startswith("contact force falls after")
    (stays,) = left(0.05, LIFT_OFF_S + 0.05).wrong
    assert stays.startswith("contact force off after")
    assert judge(done, truth).wrong == ["no contact at the patient's stop"]


@pytest.mark.parametrize(
    ("name", "most_c", "said"),
    [("plate_c", PLATE_PEAK_C, "operator's plate"), ("sensor_plate_c", SENSOR_PLATE_C, "sensor's plate")],
)
def test_a_plate_above_its_limit_is_wrong_under_any_fault(name: str, most_c: float, said: str) -> None:
    def warmed(truth: Truth, plate_c: float) -> Truth:
        return replace(truth, **{name: with_entry(getattr(truth, name), END_S, plate_c)})

    assert judged(lambda truth: warmed(truth, most_c)).wrong == []
    assert said in judged(lambda truth: warmed(truth, most_c + 0.01)).wrong[0]
    assert said in judged(lambda truth: warmed(truth, np.nan)).wrong[0]


def test_a_plate_that_was_not_recorded_is_wrong() -> None:
    early = {name: getattr(stroking(0.0, 0.0), name) - NEXT_S for name in ("finger_s", "patient_s")}
    wrong = judged(lambda truth: replace(truth, **early)).wrong
    assert {f"{name} plate: nothing was recorded" for name in ("operator's", "sensor's")} <= set(wrong)
