"""Duties of every serial module that receives invalid input, or whose host does not read."""

from common.buses.serial_messages import (
    MAX_FRAME,
    DeviceFlag,
    DeviceKind,
    HeaterCommand,
    MessageId,
    TactTipCommand,
    encode_frame,
)
from teletaction.conformance.checklist import Checklist, NotApplicable, Outcome, all_good
from teletaction.conformance.every_module import device_times_s, pace_of
from teletaction.conformance.module_talk import ANSWER_S, ModuleTalk, Span, damaged

DISTURBED: Checklist[ModuleTalk] = Checklist("Every serial module, disturbed")

UNKNOWN_ID = 0x7E
COMMANDS: dict[DeviceKind, tuple[int, bytes]] = {
    DeviceKind.THERMAL_SENSOR: (MessageId.HEATER_COMMAND, HeaterCommand(0).encode()),
    DeviceKind.TACTTIP: (MessageId.TACTTIP_COMMAND, TactTipCommand(0, 0).encode()),
}
"""Neutral command of each kind of device that has commands: message id and payload."""
FLAGS_AT = 8
"""Byte offset of the flags in the reports of every device with drives."""
AWAY_S = 2.0


def _ignores(talk: ModuleTalk, wrong: bytes, what: str) -> Outcome:
    """Check that `wrong` gets no answer and that the next IDENTIFY gets one."""
    talk.end.send(wrong)
    answers = talk.listen(ANSWER_S).of(MessageId.IDENTITY)
    if answers:
        return Outcome(False, f"{what} was answered")
    if not talk.ask(2.0 * ANSWER_S):
        return Outcome(False, f"no answer to a good IDENTIFY after {what}")
    return Outcome(True, f"{what}: ignored")


@DISTURBED.duty("S11", "A good frame with an unknown id, or a command of another kind of device, changes nothing")
def _unknown(talk: ModuleTalk) -> Outcome:
    said_at_rest = {heard.frame.message_id for heard in talk.at_rest.frames}
    if not said_at_rest:
        raise NotApplicable("no reports")
    for message_id, payload in [(UNKNOWN_ID, b"\1\2\3"), *foreign_commands(talk.kind)]:
        talk.say(message_id, payload)
        span = talk.listen(0.2)
        if {heard.frame.message_id for heard in span.frames} - said_at_rest:
            return Outcome(False, f"message {message_id:#04x}: answered")
        if not span.frames:
            return Outcome(False, f"message {message_id:#04x}: no more reports")
        if _timed_out(talk, talk.at_rest) and not _timed_out(talk, span):
            return Outcome(False, f"message {message_id:#04x}: taken for a command, COMMAND_TIMEOUT is 0")
    return Outcome(True, "they changed nothing")


def _timed_out(talk: ModuleTalk, span: Span) -> bool:
    """Return whether every intact report has COMMAND_TIMEOUT set; always True for a device without commands."""
    if talk.kind not in COMMANDS:
        return True
    return all(
        heard.frame.payload[FLAGS_AT] & DeviceFlag.COMMAND_TIMEOUT
        for heard in talk.reports(span)
        if len(heard.frame.payload) > FLAGS_AT
    )


def foreign_commands(kind: DeviceKind) -> list[tuple[int, bytes]]:
    """Return the neutral commands of the other kinds of device, as id and payload."""
    return [(message_id, payload) for of, (message_id, payload) in COMMANDS.items() if of is not kind]


@DISTURBED.duty("S12", "An IDENTIFY of a wrong length is refused")
def _long_identify(talk: ModuleTalk) -> Outcome:
    return _ignores(talk, talk.frame(MessageId.IDENTIFY, b"\1"), "IDENTIFY with an extra byte")


@DISTURBED.duty("S13", "Damaged frames are ignored, and the next good one is not: wrong CRC, COBS, length")
def _damaged(talk: ModuleTalk) -> Outcome:
    good = talk.frame(MessageId.IDENTIFY)
    wrong = {
        "wrong CRC": damaged(good),
        "wrong COBS": b"\xf0" + good[1:],
        "3 bytes": b"\x04\x01\x02\x03\0",
        f"{MAX_FRAME + 1} bytes": _too_long(talk),
    }
    return all_good((_ignores(talk, data, what) for what, data in wrong.items()), f"ignored: {', '.join(wrong)}")


def _too_long(talk: ModuleTalk) -> bytes:
    """Return a frame that is one byte too long; it has no zero byte, so its COBS is one block."""
    longest = encode_frame(UNKNOWN_ID, 1, b"\x55" * (MAX_FRAME - 4))
    return bytes((longest[0] + 1,)) + longest[1:-1] + b"\x55\0"


@DISTURBED.duty(
    "S14", "Zero bytes between frames are no error, and a zero byte ends a frame that was left in the middle"
)
def _delimiters(talk: ModuleTalk) -> Outcome:
    good = talk.frame(MessageId.IDENTIFY)
    talk.end.send(good[:3] + b"\0\0\0" + good)
    answers = len(talk.listen(2.0 * ANSWER_S).of(MessageId.IDENTITY))
    return Outcome(answers > 0, f"{answers} answers to one IDENTIFY behind half a frame and three zero bytes")


@DISTURBED.duty(
    "S15", "Any number of bytes without a zero byte is tolerated, and the frame after the next zero byte is read"
)
def _endless(talk: ModuleTalk) -> Outcome:
    return _ignores(talk, b"\xa5" * 5000 + b"\0", "5000 bytes without a zero byte")


@DISTURBED.duty(
    "S16", "A host that does not read for 2 s finds the newest report current: the oldest were dropped, whole"
)
def _unread(talk: ModuleTalk) -> Outcome:
    pace, _ = pace_of(talk)
    before = talk.reports(talk.listen(0.2))
    if pace <= 0.0:
        raise NotApplicable("a clock that stands")
    if not before:
        return Outcome(False, "no more reports")
    talk.end.look_away(AWAY_S)
    talk.begin_anew()
    after = talk.reports(talk.listen(0.5))
    if not after:
        return Outcome(False, "no more reports")
    newest = [before[-1], after[-1]]
    late_s = newest[1].at_s - newest[0].at_s - device_times_s(newest)[-1] / pace
    return Outcome(abs(late_s) <= ANSWER_S, f"the newest report is {round(1e3 * late_s)} ms older than before")
