"""Duties of every module with drives: its behaviour with commands and without them."""

from common.buses.serial_messages import DeviceFlag, MessageId
from common.buses.thermometry import COUNT_MAX
from common.limits import MODULE_TIMEOUT_S
from teletaction.conformance.checklist import (
    HALF_A_REPORT_S,
    RATE_SHARE,
    TRIALS,
    Checklist,
    How,
    NotApplicable,
    Outcome,
    acting_s,
    all_good,
    phases,
    require_punctual,
    span_s,
)
from teletaction.conformance.disturbed_module import UNKNOWN_ID, foreign_commands
from teletaction.conformance.drives import OFF, REPEAT_S, Drives, DriveState
from teletaction.conformance.every_module import reports_hz
from teletaction.conformance.module_talk import ReceivedFrame, Span, damaged

DRIVEN: Checklist[Drives] = Checklist("Every module with drives: thermal sensor, TactTip")

REPORTS, PLATE_MOVES_K = 10, 0.1
"""Number of reports averaged to a plate's temperature, and smallest change expected of it, K."""
_KNOWN_FLAGS = sum(DeviceFlag)


def _at_rest(drives: Drives) -> list[DriveState]:
    states = drives.states(drives.talk.at_rest)
    if not states:
        raise NotApplicable("no sound reports")
    return states


@DRIVEN.duty("D1", "Without a command everything is off, exactly 0, and COMMAND_TIMEOUT is set")
def _off(drives: Drives) -> Outcome:
    states = _at_rest(drives)
    strange = next((state for state in states if state.applied != OFF or not state.timed_out), None)
    if strange is None:
        return Outcome(True, f"in all of {len(states)} reports")
    return Outcome(False, f"{drives.words(strange.applied)}, flags {strange.flags:#04x}")


@DRIVEN.duty("D2", "Flags that the page does not name are 0")
def _flags(drives: Drives) -> Outcome:
    seen = {state.flags for state in _at_rest(drives)}
    return Outcome(
        not any(flags & ~_KNOWN_FLAGS for flags in seen), ", ".join(f"{flags:#04x}" for flags in sorted(seen))
    )


@DRIVEN.duty("D3", "Both thermometers read between the ends of their scale: nothing is open, nothing short")
def _thermometers(drives: Drives) -> Outcome:
    ends = [state.counts for state in _at_rest(drives)]
    low, high = min(min(pair) for pair in ends), max(max(pair) for pair in ends)
    return Outcome(low > 0 and high < COUNT_MAX, f"{low} to {high} counts")


@DRIVEN.duty("D4", "A command is applied and reported as it was sent; COMMAND_TIMEOUT is 0 meanwhile", How.EXERCISE)
def _obeys(drives: Drives) -> Outcome:
    drives.ready()
    permille, motor_mv = drives.mild
    for wanted in ((permille, motor_mv), (-permille, motor_mv)):
        last = drives.hold(*wanted, 0.2)[-1:]
        if not last or last[0].applied != wanted or last[0].timed_out:
            came = f"{drives.words(last[0].applied)}, flags {last[0].flags:#04x}" if last else "no report"
            return Outcome(False, f"commanded {drives.words(wanted)}: {came}")
    return Outcome(True, f"{drives.words(drives.mild)}, and the same cooling")


@DRIVEN.duty(
    "D5",
    "A positive drive heats the plate, a negative one cools it: 0.1 K at least in 1 s of 300 thousandths",
    How.EXERCISE,
)
def _heats(drives: Drives) -> Outcome:
    at_rest_c, heated_c, cooled_c = (_mean_c(states[-REPORTS:]) for states in drives.each_way)
    heated_k, cooled_k = heated_c - at_rest_c, cooled_c - heated_c
    return Outcome(
        heated_k >= PLATE_MOVES_K and cooled_k <= -PLATE_MOVES_K, f"{heated_k:+.2f} K heated, {cooled_k:+.2f} K cooled"
    )


def _mean_c(states: list[DriveState]) -> float:
    if not states:
        raise NotApplicable("no reports while it is driven")
    return sum(state.plate_c for state in states) / len(states)


@DRIVEN.duty(
    "D6", "100 ms after the last command at the latest everything is off, and COMMAND_TIMEOUT is set", How.EXERCISE
)
def _times_out(drives: Drives) -> Outcome:
    drives.ready()
    longest_s = 0.0
    for _ in phases(drives):
        drives.drive(*drives.mild)
        states = drives.listen(4.0 * MODULE_TIMEOUT_S)
        longest_s = max(longest_s, acting_s((state.device_s, state.applied != OFF) for state in states))
        if states and (states[-1].applied != OFF or not states[-1].timed_out):
            return Outcome(False, f"0.4 s later: {drives.words(states[-1].applied)}, flags {states[-1].flags:#04x}")
    return Outcome(
        longest_s <= MODULE_TIMEOUT_S + HALF_A_REPORT_S,
        f"one command seen to act for {1e3 * longest_s:.0f} ms at most, of {TRIALS}",
    )


@DRIVEN.duty("D7", "A command that is repeated every 20 ms stays in force without a gap", How.EXERCISE)
def _holds(drives: Drives) -> Outcome:
    drives.ready()
    states = drives.hold(*drives.mild, 0.1) and drives.hold(*drives.mild, 1.0)
    gaps = sum(state.timed_out for state in states)
    if gaps:
        require_punctual(drives.away_s)
    return Outcome(bool(states) and not gaps, f"{gaps} of {len(states)} reports say COMMAND_TIMEOUT")


def _feeds(drives: Drives, wrong: bytes, what: str) -> Outcome:
    """Send one good command, then only `wrong` for 0.25 s; check that nothing else is applied and the time-out acts."""
    drives.settle()
    drives.drive(*drives.mild)
    states: list[DriveState] = []
    until_s = drives.talk.end.now() + 2.5 * MODULE_TIMEOUT_S
    while drives.talk.end.now() < until_s:
        drives.talk.end.send(wrong)
        states = drives.listen(REPEAT_S) or states
        strange = next((state.applied for state in states if state.applied not in (OFF, drives.mild)), None)
        if strange is not None:
            return Outcome(False, f"{what}: applied {drives.words(strange)}")
    fed = bool(states) and not states[-1].timed_out
    return Outcome(not fed, f"{what}: " + ("holds off the time-out" if fed else "refused"))


def _all_refused(drives: Drives, wrong: dict[str, bytes]) -> Outcome:
    drives.ready()
    return all_good((_feeds(drives, data, what) for what, data in wrong.items()), f"refused: {', '.join(wrong)}")


@DRIVEN.duty(
    "D8",
    "A command with a value out of range is refused as a whole: it is not clipped and does not restart the time-out",
    How.EXERCISE,
)
def _range(drives: Drives) -> Outcome:
    return _all_refused(
        drives, {what: drives.talk.frame(drives.command_id, payload) for what, payload in drives.refused.items()}
    )


@DRIVEN.duty("D9", "A command of a wrong length is refused as a whole", How.EXERCISE)
def _length(drives: Drives) -> Outcome:
    sound = drives.command(drives.mild[0] // 2)
    wrong = {"a byte too few": sound[:-1], "a byte too many": sound + b"\0", "no bytes": b""}
    return _all_refused(
        drives, {what: drives.talk.frame(drives.command_id, payload) for what, payload in wrong.items()}
    )


@DRIVEN.duty("D10", "A damaged command changes nothing and does not restart the time-out", How.EXERCISE)
def _damaged(drives: Drives) -> Outcome:
    frame = drives.talk.frame(drives.command_id, drives.command(drives.mild[0] // 2))
    return _all_refused(drives, {"wrong CRC": damaged(frame)})


@DRIVEN.duty(
    "D11",
    "IDENTIFY, an unknown id and another device's command are no commands: they do not restart the time-out",
    How.EXERCISE,
)
def _no_commands(drives: Drives) -> Outcome:
    none = {"IDENTIFY": (MessageId.IDENTIFY, b""), "an unknown id": (UNKNOWN_ID, b"\1\2\3")}
    none["another device's command"] = foreign_commands(drives.talk.kind)[0]
    return _all_refused(drives, {what: drives.talk.frame(*frame) for what, frame in none.items()})


@DRIVEN.duty(
    "D12", "250 commands a second (thermal sensor: 100) leave the reports at their rate within 5 %", How.EXERCISE
)
def _keeps_rate(drives: Drives) -> Outcome:
    drives.ready()
    at_rest_hz = reports_hz(drives.talk, drives.talk.reports(drives.talk.at_rest))
    heard: list[ReceivedFrame] = []
    until_s = drives.talk.end.now() + 1.0
    while drives.talk.end.now() < until_s:
        drives.drive(*drives.mild)
        heard += drives.talk.listen(0.004 if drives.tacttip else 0.01).frames
    times_s = [report.at_s for report in drives.talk.reports(Span(heard, 0))]
    if len(times_s) < 2:
        return Outcome(False, "no reports while commands come")
    rate_hz = (len(times_s) - 1) / span_s(times_s)
    return Outcome(abs(rate_hz / at_rest_hz - 1.0) <= RATE_SHARE, f"{rate_hz:.1f} a second, {at_rest_hz:.1f} at rest")


@DRIVEN.duty("D13", "IDENTIFY is answered within 100 ms while commands come", How.EXERCISE)
def _answers(drives: Drives) -> Outcome:
    drives.ready()
    answered, slowest_s = 0, 0.0
    for _ in range(TRIALS):
        drives.hold(*drives.mild, 0.06)
        answers = drives.talk.ask()
        answered += bool(answers)
        slowest_s = max([slowest_s, *answers[:1]])
    return Outcome(answered == TRIALS, f"{answered} of {TRIALS}, the slowest after {1e3 * slowest_s:.1f} ms")
