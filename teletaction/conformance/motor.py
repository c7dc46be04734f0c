"""Duties of the TactTip's module alone: its water-cooled side, and the motor pulses that it times itself."""

from statistics import median

from common.buses.serial_messages import MessageId, TactTipCommand
from common.buses.thermometry import COUNT_MAX, ntc_c
from operator_site.devices.hot_side import COLDEST_C, MOVED_K, WARMEST_C
from teletaction.conformance.checklist import HALF_A_REPORT_S, TRIALS, Checklist, How, NotApplicable, Outcome, acting_s
from teletaction.conformance.drives import Drives, DriveState

TACTTIP: Checklist[Drives] = Checklist("TactTip")

PULSE_MV, HOLD_MV = 1000, 500
PULSE_S, ENDED_S, REPORT_S = 0.04, 0.025, 0.01
LAG_S = 0.03


def _pulsed_s(states: list[DriveState], pulse_mv: int) -> tuple[float, int]:
    """Return the time from the first to the last report of a pulse, s, and the number of these reports."""
    seen = [(state.device_s, state.motor_mv == pulse_mv) for state in states]
    return acting_s(seen), sum(pulsed for _, pulsed in seen)


@TACTTIP.duty("T1", "The hot side is within 10 to 30 C")
def _hot_side(drives: Drives) -> Outcome:
    coldest_c, warmest_c = _hot_side_c(drives.states(drives.talk.at_rest))
    return Outcome(coldest_c >= COLDEST_C and warmest_c <= WARMEST_C, f"{coldest_c:.1f} to {warmest_c:.1f} C")


def _hot_side_c(states: list[DriveState]) -> tuple[float, float]:
    """Return the coldest and the warmest reading of the hot side, C."""
    counts = [state.counts[1] for state in states if 0 < state.counts[1] < COUNT_MAX]
    if not counts:
        raise NotApplicable("no valid reading of the hot side")
    return ntc_c(max(counts)), ntc_c(min(counts))


@TACTTIP.duty(
    "T2",
    "A pulse, of 1 V or of 0, is at the motor for its length, timed by the module, and then the voltage to hold",
    How.EXERCISE,
)
def _pulse(drives: Drives) -> Outcome:
    drives.ready()
    words = []
    for pulse_mv in (PULSE_MV, 0):
        lasted_s, other_mv = 0.0, list[int]()
        for _ in range(TRIALS):
            drives.hold(0, HOLD_MV, 0.04)
            drives.say(drives.pulse(HOLD_MV, pulse_mv, round(1e6 * PULSE_S)))
            said = drives.listen(0.09)
            states = [state for state in said if not state.timed_out]  # a late host also sees the time-out
            lasted_s = max(lasted_s, _pulsed_s(states, pulse_mv)[0])
            other_mv = sorted({*other_mv, *(state.motor_mv for state in states)} - {pulse_mv})
        words.append(f"40 ms of {pulse_mv} mV seen for {1e3 * lasted_s:.0f} ms, else {other_mv} mV")
        in_time = PULSE_S - 2.0 * REPORT_S <= lasted_s <= PULSE_S + HALF_A_REPORT_S
        if not in_time or other_mv != [HOLD_MV]:
            return Outcome(False, words[-1])
    return Outcome(True, "; ".join(words))


@TACTTIP.duty("T3", "Later commands with the number of a pulse neither prolong nor repeat it", How.EXERCISE)
def _same_number(drives: Drives) -> Outcome:
    drives.ready()
    command, spans = drives.pulse(HOLD_MV, PULSE_MV, round(1e6 * PULSE_S)), []
    for _ in range(20):
        drives.say(command)
        spans.append(drives.talk.listen(REPORT_S))
    lasted_s, reports = _pulsed_s(drives.states_of(spans), PULSE_MV)
    return Outcome(
        lasted_s <= PULSE_S + HALF_A_REPORT_S,
        f"40 ms seen for {1e3 * lasted_s:.0f} ms in {reports} reports, of 20 commands",
    )


@TACTTIP.duty("T4", "A new number begins a new pulse; a length of 0 ends one that is under way", How.EXERCISE)
def _new_and_none(drives: Drives) -> Outcome:
    drives.ready()
    lasted_s, begun = [], 0
    for _ in range(TRIALS):
        command = drives.pulse(HOLD_MV, PULSE_MV, 50_000)
        drives.say(command)
        spans = [drives.talk.listen(0.015)]
        drives.say(TactTipCommand(HOLD_MV, 0, PULSE_MV, 0, command.pulse_number))
        spans.append(drives.talk.listen(0.06))
        seen_s, reports = _pulsed_s(drives.states_of(spans), PULSE_MV)
        begun += reports > 0
        lasted_s.append(seen_s)
    # A pulse that continues is seen for 30 ms every time. The host's delay can only lengthen a pulse that is ended.
    return Outcome(
        begun == TRIALS and min(lasted_s) < ENDED_S,
        f"{begun} of {TRIALS} begun; of 50 ms the end left {1e3 * min(lasted_s):.0f} to {1e3 * max(lasted_s):.0f} ms",
    )


@TACTTIP.duty("T5", "Takes 250 commands a second: what it reports is less than 30 ms old", How.EXERCISE)
def _budget(drives: Drives) -> Outcome:
    drives.ready()
    sent_s: dict[int, float] = {}
    late_s: list[float] = []
    for step in range(200):
        motor_mv = HOLD_MV + step
        sent_s[motor_mv] = drives.talk.end.now()
        drives.drive(0, motor_mv)
        for heard in drives.talk.listen(0.004).of(MessageId.TACTTIP_STATE):
            applied_mv = int.from_bytes(heard.frame.payload[9:11], "little")
            if applied_mv in sent_s:
                late_s.append(heard.at_s - sent_s[applied_mv])
    if not late_s:
        return Outcome(False, "none of 200 commands was reported")
    return Outcome(median(late_s) < LAG_S, f"{1e3 * median(late_s):.1f} ms old (median of {len(late_s)})")


@TACTTIP.duty("T6", "Water holds the hot side within 2.5 K while the plate is driven for 1 s each way", How.EXERCISE)
def _water(drives: Drives) -> Outcome:
    coldest_c, warmest_c = _hot_side_c([state for states in drives.each_way for state in states])
    return Outcome(warmest_c - coldest_c <= MOVED_K, f"{coldest_c:.1f} to {warmest_c:.1f} C")
