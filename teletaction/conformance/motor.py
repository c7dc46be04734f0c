"""Duties of the TactTip's module alone: its water-cooled side, and a motor whose pulses it times itself."""

from statistics import median

from common.serial_messages import MessageId, TactTipCommand
from common.thermometry import COUNT_MAX, ntc_c
from teletaction.conformance.checklist import HALF_A_REPORT_S, Came, Checklist, How, NotApplicable
from teletaction.conformance.drives import Doing, Drives

TACTTIP: Checklist[Drives] = Checklist("TactTip")

HOT_SIDE_C = (10.0, 30.0)
PULSE_MV, HOLD_MV = 1000, 500
PULSE_S, REPORT_S = 0.04, 0.01
LAG_S = 0.03


class Pulses:
    """Commands with pulses, each under a number of its own."""

    number = 0

    @classmethod
    def new(cls, pulse_us: int) -> TactTipCommand:
        """A pulse of a new number, and the voltage that holds behind it."""
        cls.number = (cls.number + 1) & 0xFF
        return TactTipCommand(HOLD_MV, 0, PULSE_MV, pulse_us, cls.number)


def _pulsed_s(doings: list[Doing]) -> tuple[float, int]:
    """From the first to the last report of a pulse, s, and how many there were."""
    seen = [doing.device_s for doing in doings if doing.motor_mv == PULSE_MV]
    return (seen[-1] - seen[0] if seen else 0.0), len(seen)


def _say(drives: Drives, command: TactTipCommand, seconds: float) -> list[Doing]:
    drives.say(command)
    return drives.listen(seconds)


@TACTTIP.duty("T1", "The hot side is within 10 to 30 C")
def _hot_side(drives: Drives) -> Came:
    counts = [doing.counts[1] for doing in drives.doings(drives.talk.at_rest) if 0 < doing.counts[1] < COUNT_MAX]
    if not counts:
        raise NotApplicable("no sound reading of it")
    coldest_c, warmest_c = ntc_c(max(counts)), ntc_c(min(counts))
    return Came(HOT_SIDE_C[0] <= coldest_c and warmest_c <= HOT_SIDE_C[1], f"{coldest_c:.1f} to {warmest_c:.1f} C")


@TACTTIP.duty(
    "T2",
    "A pulse is at the motor for its length, timed by the module, and the voltage behind it after that",
    How.EXERCISE,
)
def _pulse(drives: Drives) -> Came:
    drives.ready()
    doings = _say(drives, Pulses.new(round(1e6 * PULSE_S)), 0.09)
    lasted_s, reports = _pulsed_s(doings)
    behind = [doing.motor_mv for doing in doings if doing.motor_mv not in (0, PULSE_MV)]
    good = (
        PULSE_S - 2.0 * REPORT_S <= lasted_s <= PULSE_S + HALF_A_REPORT_S
        and reports > 0
        and behind
        and set(behind) == {HOLD_MV}
    )
    return Came(bool(good), f"40 ms seen for {1e3 * lasted_s:.0f} ms, then {sorted(set(behind))} mV")


@TACTTIP.duty("T3", "Later commands with the number of a pulse neither prolong nor repeat it", How.EXERCISE)
def _same_number(drives: Drives) -> Came:
    drives.ready()
    command, spans = Pulses.new(round(1e6 * PULSE_S)), []
    for _ in range(20):
        drives.say(command)
        spans.append(drives.talk.listen(REPORT_S))
    lasted_s, reports = _pulsed_s(drives.doings_of(spans))
    return Came(
        lasted_s <= PULSE_S + HALF_A_REPORT_S,
        f"40 ms seen for {1e3 * lasted_s:.0f} ms in {reports} reports, of 20 commands",
    )


@TACTTIP.duty("T4", "A new number begins a new pulse; a length of 0 ends one that is under way", How.EXERCISE)
def _new_and_none(drives: Drives) -> Came:
    drives.ready()
    seen = []
    for _ in range(3):
        command = Pulses.new(50_000)
        began = _say(drives, command, 0.015)
        ended = _say(drives, TactTipCommand(HOLD_MV, 0, PULSE_MV, 0, command.pulse_number), 0.03)
        seen.append((any(doing.motor_mv == PULSE_MV for doing in began), ended[-1].motor_mv if ended else PULSE_MV))
    begun = sum(begins for begins, _ in seen)
    over = sum(millivolts == HOLD_MV for _, millivolts in seen)
    return Came(begun == over == 3, f"{begun} of 3 begun, {over} of 3 ended")


@TACTTIP.duty("T5", "Takes 250 commands a second: what it reports is less than 30 ms old", How.EXERCISE)
def _budget(drives: Drives) -> Came:
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
        return Came(False, "none of 200 commands was reported")
    return Came(median(late_s) < LAG_S, f"{1e3 * median(late_s):.1f} ms old (median of {len(late_s)})")
