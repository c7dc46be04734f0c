"""Duties of every serial module: its identity, its frames, and its reports."""

from collections.abc import Callable
from itertools import pairwise

from common.buses.serial_device import plain_name
from common.buses.serial_messages import (
    BadPayload,
    DeviceKind,
    Identity,
    MessageId,
    PatientSwitchState,
    TactTipState,
    TextureSamples,
    ThermalReading,
)
from common.fingers import FINGERS
from teletaction.conformance.checklist import RATE_SHARE, STOPPED_S, Checklist, NotApplicable, Outcome, Unsafe, span_s
from teletaction.conformance.module_talk import ANSWER_S, REPORTS, REST_S, ModuleTalk, ReceivedFrame

MODULE: Checklist[ModuleTalk] = Checklist("Every serial module")

ASKED = 5
PAUSED_REPORTS = 4
"""Longest time between two reports after a question, in reports; a line may lose three."""
RANGES = {
    DeviceKind.TEXTURE_SENSOR: (-10.0, 10.0),
    DeviceKind.THERMAL_SENSOR: (0.0, 60.0),
    DeviceKind.PATIENT_SWITCH: (0.0, 1.0),
}

_DECODE: dict[MessageId, Callable[[bytes], object]] = {
    MessageId.TEXTURE_SAMPLES: TextureSamples.decode,
    MessageId.THERMAL_READING: ThermalReading.decode,
    MessageId.TACTTIP_STATE: TactTipState.decode,
    MessageId.PATIENT_SWITCH_STATE: PatientSwitchState.decode,
}


def device_times_s(reports: list[ReceivedFrame]) -> list[float]:
    """Return the device times of reports, s, unwrapped from 32 bits; the first is 0."""
    times = [0]
    stamps = [int.from_bytes(heard.frame.payload[:4], "little") for heard in reports]
    for before, after in pairwise(stamps):
        step = (after - before) & 0xFFFFFFFF
        times.append(times[-1] + (step if step < 1 << 31 else step - (1 << 32)))
    return [1e-6 * us for us in times]


@MODULE.duty("S1", "Answers each IDENTIFY with one IDENTITY within 100 ms, while its reports continue")
def _answers(talk: ModuleTalk) -> Outcome:
    answers: list[list[float]] = []
    reports = talk.reports(talk.listen(PAUSED_REPORTS / talk.rate_hz))
    for _ in range(ASKED):
        asked_s = talk.end.now()
        talk.say(MessageId.IDENTIFY)
        span = talk.listen(2.0 * ANSWER_S)
        answers.append([heard.at_s - asked_s for heard in span.of(MessageId.IDENTITY)])
        reports += talk.reports(span)
    longest_s = max((after - before for before, after in pairwise(device_times_s(reports))), default=0.0)
    if longest_s > PAUSED_REPORTS / talk.rate_hz:
        return Outcome(False, f"no report for {1e3 * longest_s:.0f} ms at a question")
    in_time = sum(len(times) == 1 and times[0] <= ANSWER_S for times in answers)
    latest_s = max((times[0] for times in answers if times), default=0.0)
    most = max(len(times) for times in answers)
    return Outcome(
        in_time == ASKED,
        f"{in_time} of {ASKED} correct; latest after {1e3 * latest_s:.1f} ms, at most {most} to one question",
    )


@MODULE.duty("S2", "IDENTITY is 22 bytes: a known kind, a finger 0 to 4, an ASCII serial number, a finite range")
def _identity(talk: ModuleTalk) -> Outcome:
    talk.say(MessageId.IDENTIFY)
    answers = talk.listen(2.0 * ANSWER_S).of(MessageId.IDENTITY)
    if not answers:
        raise NotApplicable("no answer")
    try:
        found = Identity.decode(answers[0].frame.payload)
    except BadPayload as error:
        return Outcome(False, str(error))
    words = f"{found.serial!r}, firmware {found.firmware}, {found.range_low:g} to {found.range_high:g}"
    return Outcome(bool(found.serial) and found.serial.isprintable() and found.range_low < found.range_high, words)


@MODULE.duty("S3", "Its kind and its finger are those that the host expects")
def _as_expected(talk: ModuleTalk) -> Outcome:
    found = talk.identity
    if found is None:
        raise NotApplicable("no sound answer")
    if talk.expected_kind is None and talk.expected_finger is None:
        raise NotApplicable("nothing was specified with --device or --finger")
    words = f"the {plain_name(found.kind, FINGERS[found.finger])}"
    if talk.expected_kind not in (None, found.kind) or talk.expected_finger not in (None, found.finger):
        raise Unsafe(f"{words}: not the expected device, so it is not tried")
    return Outcome(True, words)


@MODULE.duty(
    "S4", "IDENTITY contains the rate of its kind (2000 samples, 100 readings, 100 states) and the sensor's range"
)
def _promises(talk: ModuleTalk) -> Outcome:
    if talk.identity is None:
        raise NotApplicable("no sound answer")
    rate_hz = 2000 if talk.kind is DeviceKind.TEXTURE_SENSOR else 100
    found = talk.identity
    span = (found.range_low, found.range_high)
    good = found.rate_hz == rate_hz and span == RANGES.get(talk.kind, span)
    return Outcome(good, f"{found.rate_hz} Hz, {span[0]:g} to {span[1]:g}")


@MODULE.duty("S5", "Every frame is sound: COBS, 4 to 250 bytes, CRC")
def _sound(talk: ModuleTalk) -> Outcome:
    span = talk.at_rest
    return Outcome(span.damaged == 0, f"{len(span.frames)} good, {span.damaged} damaged")


@MODULE.duty("S6", "The sequence number counts all its frames, one by one, modulo 256")
def _counts(talk: ModuleTalk) -> Outcome:
    span = talk.at_rest
    numbers = [heard.frame.sequence for heard in span.frames]
    steps = [(after - before) & 0xFF for before, after in pairwise(numbers)]
    # A damaged frame had a number too.
    missing, repeated = sum(step - 1 for step in steps if step), steps.count(0)
    return Outcome(
        missing <= span.damaged and not repeated,
        f"{missing} numbers missing and {repeated} repeated in {len(numbers)} frames, {span.damaged} damaged",
    )


@MODULE.duty("S7", "Sends its reports without being asked, and unasked nothing else")
def _unasked(talk: ModuleTalk) -> Outcome:
    known = REPORTS[talk.kind]
    strange = sorted({heard.frame.message_id for heard in talk.at_rest.frames} - {known})
    reports = len(talk.reports(talk.at_rest))
    return Outcome(
        reports > 0 and not strange,
        f"{reports} reports" + (f"; and message {', '.join(f'{each:#04x}' for each in strange)}" if strange else ""),
    )


@MODULE.duty("S8", "Every report has the length of its layout, and every value is within its range")
def _layout(talk: ModuleTalk) -> Outcome:
    reports = talk.reports(talk.at_rest)
    for heard in reports:
        try:
            _DECODE[REPORTS[talk.kind]](heard.frame.payload)
        except BadPayload as error:
            return Outcome(False, str(error))
    if not reports:
        raise NotApplicable("no reports")
    return Outcome(True, f"{len(reports)} correct reports")


def reports_hz(talk: ModuleTalk, reports: list[ReceivedFrame]) -> float:
    """Return the reports a second by the host's clock, including those damaged in transmission."""
    lasted_s = span_s([heard.at_s for heard in reports])
    numbers = [heard.frame.sequence for heard in reports]
    # The numbers of the neighbours show how many reports are missing, if fewer than 256 are missing at once.
    lost = min(talk.at_rest.damaged, sum((b - a - 1) & 0xFF for a, b in pairwise(numbers)))
    return (len(reports) - 1 + lost) / lasted_s


@MODULE.duty(
    "S9",
    "Reports come at the rate of their kind within 5 %: 200 (texture sensor) or 100 messages a second",
)
def _rate(talk: ModuleTalk) -> Outcome:
    reports = talk.reports(talk.at_rest)
    rate_hz = reports_hz(talk, reports)
    words = f"{rate_hz:.1f} a second"
    if (lasted_s := span_s([heard.at_s for heard in reports])) < REST_S - STOPPED_S:
        return Outcome(False, f"{words}, but only for {lasted_s:.1f} of {REST_S:g} s")
    return Outcome(abs(rate_hz / talk.rate_hz - 1.0) <= RATE_SHARE, words)


def pace_of(talk: ModuleTalk) -> tuple[float, list[float]]:
    """Return the device's seconds in one second of the host, and the device times at rest, s."""
    reports = talk.reports(talk.at_rest)
    lasted_s = span_s([heard.at_s for heard in reports])
    times_s = device_times_s(reports)
    return times_s[-1] / lasted_s, times_s


@MODULE.duty("S10", "Device time is in microseconds, rises from report to report, and keeps the host's pace within 5 %")
def _time(talk: ModuleTalk) -> Outcome:
    pace, times_s = pace_of(talk)
    least_s = min(b - a for a, b in pairwise(times_s))
    return Outcome(
        least_s > 0.0 and abs(pace - 1.0) <= RATE_SHARE,
        f"{pace:.3f} s of the device in one of the host, smallest step {1e3 * least_s:.3f} ms",
    )
