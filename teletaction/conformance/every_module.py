"""Duties of every serial module: who it is, its frames, its reports, and what it must not be put off by."""

from collections.abc import Callable
from itertools import pairwise

from common.fingers import FINGERS
from common.framing import MAX_FRAME, encode_frame
from common.serial_messages import (
    BadPayload,
    DeviceFlag,
    DeviceKind,
    HeaterCommand,
    Identity,
    MessageId,
    TactTipCommand,
    TactTipState,
    TextureSamples,
    ThermalReading,
)
from teletaction.conformance.checklist import RATE_SHARE, Came, Checklist, NotApplicable, Unsafe
from teletaction.conformance.module_talk import ANSWER_S, REPORTS, Heard, ModuleTalk, Span, damaged

MODULE: Checklist[ModuleTalk] = Checklist("Every serial module")

ASKED = 10
UNKNOWN_ID = 0x7E
RANGES = {DeviceKind.TEXTURE_SENSOR: (-10.0, 10.0), DeviceKind.THERMAL_SENSOR: (0.0, 60.0)}
COMMANDS: dict[DeviceKind, tuple[int, bytes]] = {
    DeviceKind.THERMAL_SENSOR: (MessageId.HEATER_COMMAND, HeaterCommand(0).encode()),
    DeviceKind.TACTTIP: (MessageId.TACTTIP_COMMAND, TactTipCommand(0, 0).encode()),
}
"""Commands of the devices that have any, asking for nothing."""
AWAY_S = 2.0
FLAGS_AT = 8
"""Where the flags stand in the reports of every device that has drives."""

_DECODE: dict[MessageId, Callable[[bytes], object]] = {
    MessageId.TEXTURE_SAMPLES: TextureSamples.decode,
    MessageId.THERMAL_READING: ThermalReading.decode,
    MessageId.TACTTIP_STATE: TactTipState.decode,
}


def device_times_s(reports: list[Heard]) -> list[float]:
    """Device times of reports, s, going on where the 32 bits wrap; the first is 0."""
    times = [0]
    stamps = [int.from_bytes(heard.frame.payload[:4], "little") for heard in reports]
    for before, after in pairwise(stamps):
        step = (after - before) & 0xFFFFFFFF
        times.append(times[-1] + (step if step < 1 << 31 else step - (1 << 32)))
    return [1e-6 * us for us in times]


def _ignores(talk: ModuleTalk, wrong: bytes, what: str) -> Came:
    """Whether what was sent brings no answer, and the next IDENTIFY brings one."""
    talk.end.send(wrong)
    answers = talk.listen(ANSWER_S).of(MessageId.IDENTITY)
    if answers:
        return Came(False, f"{what} was answered")
    if not talk.ask(2.0 * ANSWER_S):
        return Came(False, f"no answer to a good IDENTIFY after {what}")
    return Came(True, f"{what}: ignored")


def _all(talk: ModuleTalk, wrong: dict[str, bytes]) -> Came:
    for what, data in wrong.items():
        came = _ignores(talk, data, what)
        if not came.good:
            return came
    return Came(True, f"ignored: {', '.join(wrong)}")


@MODULE.duty("S1", "Answers each IDENTIFY with one IDENTITY within 100 ms, while its reports go on")
def _answers(talk: ModuleTalk) -> Came:
    answers = [talk.ask(2.0 * ANSWER_S) for _ in range(ASKED)]
    in_time = sum(len(times) == 1 and times[0] <= ANSWER_S for times in answers)
    latest_s = max((times[0] for times in answers if times), default=0.0)
    most = max(len(times) for times in answers)
    return Came(
        in_time == ASKED,
        f"{in_time} of {ASKED} so; latest after {1e3 * latest_s:.1f} ms, at most {most} to one question",
    )


@MODULE.duty("S2", "IDENTITY is 22 bytes: a known kind, a finger 0 to 4, an ASCII serial number, a finite range")
def _identity(talk: ModuleTalk) -> Came:
    talk.say(MessageId.IDENTIFY)
    answers = talk.listen(2.0 * ANSWER_S).of(MessageId.IDENTITY)
    if not answers:
        raise NotApplicable("no answer")
    try:
        found = Identity.decode(answers[0].frame.payload)
    except BadPayload as error:
        return Came(False, str(error))
    words = f"{found.serial!r}, firmware {found.firmware}, {found.range_low:g} to {found.range_high:g}"
    return Came(bool(found.serial) and found.serial.isprintable() and found.range_low < found.range_high, words)


@MODULE.duty("S3", "It is of the kind and of the finger that it is told to be")
def _told(talk: ModuleTalk) -> Came:
    found = talk.identity
    if found is None or (talk.told_kind is None and talk.told_finger is None):
        raise NotApplicable("nothing was told, or nothing answered")
    words = f"the {FINGERS[found.finger]} {found.kind.name.lower().replace('_', ' ')}"
    if talk.told_kind not in (None, found.kind) or talk.told_finger not in (None, found.finger):
        raise Unsafe(f"{words}: what was not meant is not tried")
    return Came(True, words)


@MODULE.duty(
    "S4", "IDENTITY tells the rate of its kind (2000 samples, 100 readings, 100 states) and the sensor's range"
)
def _promises(talk: ModuleTalk) -> Came:
    if talk.identity is None:
        raise NotApplicable("no sound answer")
    rate_hz = 2000 if talk.kind is DeviceKind.TEXTURE_SENSOR else 100
    found = talk.identity
    span = (found.range_low, found.range_high)
    good = found.rate_hz == rate_hz and span == RANGES.get(talk.kind, span)
    return Came(good, f"{found.rate_hz} Hz, {span[0]:g} to {span[1]:g}")


@MODULE.duty("S5", "Every frame is sound: COBS, 4 to 250 bytes, CRC")
def _sound(talk: ModuleTalk) -> Came:
    span = talk.at_rest
    return Came(span.damaged == 0, f"{len(span.frames)} good, {span.damaged} damaged")


@MODULE.duty("S6", "The sequence number counts all its frames, one by one, modulo 256")
def _counts(talk: ModuleTalk) -> Came:
    span = talk.at_rest
    numbers = [heard.frame.sequence for heard in span.frames]
    steps = [(after - before) & 0xFF for before, after in pairwise(numbers)]
    # A frame that was damaged had a number too.
    missing = sum(step - 1 if step else 256 for step in steps)
    return Came(missing <= span.damaged, f"{missing} numbers missing in {len(numbers)} frames, {span.damaged} damaged")


@MODULE.duty("S7", "Sends its reports without being asked, and unasked nothing else")
def _unasked(talk: ModuleTalk) -> Came:
    known = REPORTS[talk.kind]
    strange = sorted({heard.frame.message_id for heard in talk.at_rest.frames} - {known})
    reports = len(talk.reports(talk.at_rest))
    return Came(
        reports > 0 and not strange,
        f"{reports} reports" + (f"; and message {', '.join(f'{each:#04x}' for each in strange)}" if strange else ""),
    )


@MODULE.duty("S8", "Every report has the length of its layout, and every value is within its range")
def _layout(talk: ModuleTalk) -> Came:
    reports = talk.reports(talk.at_rest)
    for heard in reports:
        try:
            _DECODE[REPORTS[talk.kind]](heard.frame.payload)
        except BadPayload as error:
            return Came(False, str(error))
    if not reports:
        raise NotApplicable("no reports")
    return Came(True, f"{len(reports)} reports as they should be")


def reports_hz(talk: ModuleTalk, reports: list[Heard]) -> float:
    """Reports a second by the host's clock, those counted that were damaged on the way."""
    if len(reports) < 2:
        raise NotApplicable("no reports")
    numbers = [heard.frame.sequence for heard in reports]
    # Damage is told by its neighbours' numbers, as long as less than a round of 256 is gone in one go.
    lost = min(talk.at_rest.damaged, sum((b - a - 1) & 0xFF for a, b in pairwise(numbers)))
    return (len(reports) - 1 + lost) / (reports[-1].at_s - reports[0].at_s)


@MODULE.duty("S9", "Reports come at the rate of their kind within 5 %: 200, 100 and 100 messages a second")
def _rate(talk: ModuleTalk) -> Came:
    rate_hz = reports_hz(talk, talk.reports(talk.at_rest))
    return Came(abs(rate_hz / talk.rate_hz - 1.0) <= RATE_SHARE, f"{rate_hz:.1f} a second")


def _pace(talk: ModuleTalk) -> tuple[float, list[float]]:
    """Seconds of the device in one of the host, and the device times at rest."""
    reports = talk.reports(talk.at_rest)
    if len(reports) < 2:
        raise NotApplicable("no reports")
    times_s = device_times_s(reports)
    return times_s[-1] / (reports[-1].at_s - reports[0].at_s), times_s


@MODULE.duty("S10", "Device time is in microseconds, rises from report to report, and keeps the host's pace within 5 %")
def _time(talk: ModuleTalk) -> Came:
    pace, times_s = _pace(talk)
    least_s = min(b - a for a, b in pairwise(times_s))
    return Came(
        least_s > 0.0 and abs(pace - 1.0) <= RATE_SHARE,
        f"{pace:.3f} s of the device in one of the host, smallest step {1e3 * least_s:.3f} ms",
    )


@MODULE.duty("S11", "A good frame with an unknown id, or a command of another kind of device, changes nothing")
def _unknown(talk: ModuleTalk) -> Came:
    said_at_rest = {heard.frame.message_id for heard in talk.at_rest.frames}
    for message_id, payload in [(UNKNOWN_ID, b"\1\2\3"), *foreign_commands(talk.kind)]:
        talk.say(message_id, payload)
        span = talk.listen(0.2)
        if {heard.frame.message_id for heard in span.frames} - said_at_rest:
            return Came(False, f"message {message_id:#04x}: answered")
        if not span.frames:
            return Came(False, f"message {message_id:#04x}: no reports any more")
        if _timed_out(talk, talk.at_rest) and not _timed_out(talk, span):
            return Came(False, f"message {message_id:#04x}: taken for a command, COMMAND_TIMEOUT is 0")
    return Came(True, "nothing came of them")


def _timed_out(talk: ModuleTalk, span: Span) -> bool:
    """Whether every sound report says that no command is in force; a texture sensor has none."""
    if talk.kind is DeviceKind.TEXTURE_SENSOR:
        return True
    return all(
        heard.frame.payload[FLAGS_AT] & DeviceFlag.COMMAND_TIMEOUT
        for heard in talk.reports(span)
        if len(heard.frame.payload) > FLAGS_AT
    )


def foreign_commands(kind: DeviceKind) -> list[tuple[int, bytes]]:
    """Commands of the other kinds of device, id and payload, that ask for nothing."""
    return [(message_id, payload) for of, (message_id, payload) in COMMANDS.items() if of is not kind]


@MODULE.duty("S12", "An IDENTIFY of a wrong length is refused")
def _long_identify(talk: ModuleTalk) -> Came:
    return _ignores(talk, talk.frame(MessageId.IDENTIFY, b"\1"), "IDENTIFY with a byte too many")


@MODULE.duty("S13", "Damaged frames are ignored, and the next good one is not: wrong CRC, COBS, length")
def _damaged(talk: ModuleTalk) -> Came:
    good = talk.frame(MessageId.IDENTIFY)
    wrong = {
        "wrong CRC": damaged(good),
        "wrong COBS": b"\xf0" + good[1:],
        "3 bytes": b"\x04\x01\x02\x03\0",
        f"{MAX_FRAME + 1} bytes": _too_long(talk),
    }
    return _all(talk, wrong)


def _too_long(talk: ModuleTalk) -> bytes:
    """One byte more than a frame may have; all of it not zero, so that its COBS is one block."""
    longest = encode_frame(UNKNOWN_ID, 1, b"\x55" * (MAX_FRAME - 4))
    return bytes((longest[0] + 1,)) + longest[1:-1] + b"\x55\0"


@MODULE.duty("S14", "Zero bytes between frames are no error, and a zero byte ends a frame that was left in the middle")
def _delimiters(talk: ModuleTalk) -> Came:
    good = talk.frame(MessageId.IDENTIFY)
    talk.end.send(good[:3] + b"\0\0\0" + good)
    answers = len(talk.listen(2.0 * ANSWER_S).of(MessageId.IDENTITY))
    return Came(answers > 0, f"{answers} answers to one IDENTIFY behind half a frame and three zero bytes")


@MODULE.duty("S15", "Any number of bytes without a zero byte is borne, and the frame after the next zero byte is read")
def _endless(talk: ModuleTalk) -> Came:
    return _ignores(talk, b"\xa5" * 5000 + b"\0", "5000 bytes without a zero byte")


@MODULE.duty("S16", "A host that does not read for 2 s finds the newest report current: the oldest were dropped, whole")
def _unread(talk: ModuleTalk) -> Came:
    pace, _ = _pace(talk)
    before = talk.reports(talk.listen(0.2))
    if not before or pace <= 0.0:
        raise NotApplicable("no reports, or a clock that stands")
    talk.end.look_away(AWAY_S)
    talk.begin_anew()
    after = talk.reports(talk.listen(0.5))
    if not after:
        return Came(False, "no reports any more")
    newest = [before[-1], after[-1]]
    late_s = newest[1].at_s - newest[0].at_s - device_times_s(newest)[-1] / pace
    return Came(abs(late_s) <= ANSWER_S, f"the newest report is {1e3 * late_s:.0f} ms older than before")
