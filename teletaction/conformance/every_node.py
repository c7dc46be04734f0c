"""Duties of every CAN node: its frames at rest, the set-points that it obeys, and their time-out."""

from collections.abc import Callable
from functools import partial
from itertools import pairwise

import can

from common.buses.can_frames import database, frame_crc, packing
from common.limits import MODULE_TIMEOUT_S
from teletaction.conformance.checklist import (
    HALF_A_REPORT_S,
    RATE_SHARE,
    STOPPED_S,
    Checklist,
    How,
    NotApplicable,
    Outcome,
    acting_s,
    phases,
    require_punctual,
    span_s,
)
from teletaction.conformance.node_on_trial import NodeOnTrial
from teletaction.conformance.node_talk import REST_S, Command, crc_of_another, cut_short, wrong_crc

AT_ONCE = 10
"""Number of state frames in 100 ms."""

NODE: Checklist[NodeOnTrial] = Checklist("Every CAN node: exoskeleton, telemanipulator")


def _named(node: NodeOnTrial) -> dict[str, list[can.Message]]:
    """Return the frames at rest, by name."""
    return {name: node.talk.of(node.talk.at_rest, name) for name in node.talk.kind.sends_hz}


def _counters(frames: list[can.Message], name: str) -> list[int]:
    layout = packing(name)
    return [layout.unpack(bytes(frame.data))[1] for frame in frames if len(frame.data) == 8]


@NODE.duty("N1", "Sends each of its frames, unasked, and no others; its controller reports no errors")
def _frames(node: NodeOnTrial) -> Outcome:
    messages = node.talk.at_rest
    own = {packing(name).frame_id for name in node.talk.kind.sends_hz}
    missing = [name for name, frames in _named(node).items() if not frames]
    strange = sorted({each.arbitration_id for each in messages if not each.is_error_frame} - own)
    errors = sum(each.is_error_frame for each in messages)
    words = [f"no {', '.join(missing)}"] if missing else []
    words += [f"unknown {', '.join(f'{each:#05x}' for each in strange)}"] if strange else []
    words += [f"{errors} error frames"] if errors else []
    return Outcome(not words, "; ".join(words) or f"{', '.join(node.talk.kind.sends_hz)} and nothing else")


@NODE.duty("N2", "Every frame has an 11 bit identifier and 8 bytes; bits that the page does not name are 0")
def _whole(node: NodeOnTrial) -> Outcome:
    for name, frames in _named(node).items():
        named = sum(
            ((1 << signal.length) - 1) << signal.start for signal in database().get_message_by_name(name).signals
        )
        for frame in frames:
            if frame.is_extended_id or len(frame.data) != 8:
                return Outcome(False, f"{name}: {len(frame.data)} bytes, {'29' if frame.is_extended_id else '11'} bit")
            if int.from_bytes(frame.data, "little") & ~named:
                return Outcome(False, f"{name}: {bytes(frame.data).hex(' ')}")
    return Outcome(True, f"{sum(map(len, _named(node).values()))} frames")


@NODE.duty("N3", "The counter of each identifier is one more with each frame, 15 is followed by 0")
def _counter(node: NodeOnTrial) -> Outcome:
    for name, frames in _named(node).items():
        numbers = _counters(frames, name)
        wrong = [(a, b) for a, b in pairwise(numbers) if b != (a + 1) & 0xF]
        if wrong:
            return Outcome(False, f"{name}: {wrong[0][0]} is followed by {wrong[0][1]}, {len(wrong)} such")
    return Outcome(True, "without a gap and without a repetition")


@NODE.duty("N4", "The CRC is right in every frame that has one")
def _crc(node: NodeOnTrial) -> Outcome:
    checked = 0
    for name, frames in _named(node).items():
        with_crc = [each for each in frames if packing(name).has_crc and len(each.data) == 8]
        wrong = [each for each in with_crc if each.data[7] != frame_crc(each.arbitration_id, bytes(each.data))]
        if wrong:
            return Outcome(False, f"{name}: wrong in {len(wrong)} of {len(with_crc)}")
        checked += len(with_crc)
    return Outcome(True, f"{checked} frames")


@NODE.duty("N5", "What it measures comes 500 times a second, its state 100 times, within 5 %")
def _rates(node: NodeOnTrial) -> Outcome:
    found: dict[str, float] = {}
    for name, frames in _named(node).items():
        lasted_s = span_s([frame.timestamp for frame in frames], name)
        if lasted_s < REST_S - STOPPED_S:
            return Outcome(False, f"{name} came only for {lasted_s:.1f} of {REST_S:g} s")
        found[name] = (len(frames) - 1) / lasted_s
    off = max(abs(found[name] / hz - 1.0) for name, hz in node.talk.kind.sends_hz.items())
    return Outcome(off <= RATE_SHARE, ", ".join(f"{name} {hz:.0f}" for name, hz in found.items()))


@NODE.duty("N6", "Without set-points it is in its safe state and reports it: forces exactly 0, not enabled; released")
def _safe(node: NodeOnTrial) -> Outcome:
    states = [values for _, values in node.talk.states(node.talk.at_rest)]
    if not states:
        raise NotApplicable(f"no {node.talk.kind.state}")
    safe = node.talk.kind.safe
    wrong = next(((name, values[name]) for values in states for name in safe if values[name] != safe[name]), None)
    return Outcome(wrong is None, f"{wrong[0]} {wrong[1]:g}" if wrong else f"in all of {len(states)} state frames")


def _in_force(node: NodeOnTrial, messages: list[can.Message], command: Command) -> list[tuple[float, bool]]:
    """Return the times of the state frames, s, and whether the command is in force in each.

    Raises:
        NotApplicable: there are no state frames.
    """
    states = node.talk.states(messages)
    if not states:
        raise NotApplicable(f"no {node.talk.kind.state}")
    return [(at_s, values[command.in_force] > 0.0) for at_s, values in states]


def _repeat(
    node: NodeOnTrial, make: Callable[[], can.Message], command: Command, seconds: float
) -> list[tuple[float, bool]]:
    """Send frames for `seconds`; return the state frames' times and whether the command is in force in each."""
    return _in_force(node, node.talk.repeat(lambda: node.talk.end.send(make()), seconds), command)


def _good(node: NodeOnTrial, command: Command) -> can.Message:
    """Return the next correct frame of a command."""
    return node.talk.frame(command.frame, node.acting(command.frame))


def _refuses(node: NodeOnTrial, make: Callable[[Command], can.Message]) -> Outcome:
    """Send only wrong frames; check that no set-point is in force at the end."""
    for command in node.talk.kind.commands:
        said = _repeat(node, partial(make, command), command, 4.0 * MODULE_TIMEOUT_S)
        node.settle()
        if said[-1][1]:
            return Outcome(False, f"{command.frame}: in force")
    return Outcome(True, f"{', '.join(command.frame for command in node.talk.kind.commands)}: not in force")


@NODE.duty(
    "N7", "A good set-point is in force within 100 ms, and stays so while it is repeated every 10 ms", How.EXERCISE
)
def _obeys(node: NodeOnTrial) -> Outcome:
    for command in node.talk.kind.commands:
        said = _repeat(node, partial(_good, node, command), command, 5.0 * MODULE_TIMEOUT_S)
        node.settle()
        begun = next((n for n, (_, in_force) in enumerate(said) if in_force), len(said))
        gaps = sum(not in_force for _, in_force in said[begun:])
        if gaps:
            require_punctual(node.talk.away_s)
        if gaps or begun > AT_ONCE or len(said) <= AT_ONCE:
            return Outcome(
                False, f"{command.frame}: in force from state frame {begun} on, then not in {gaps} of {len(said)}"
            )
    return Outcome(True, f"{', '.join(command.frame for command in node.talk.kind.commands)}: in force throughout")


@NODE.duty("N8", "Set-points end 100 ms after the last good frame at the latest, by the node itself", How.EXERCISE)
def _times_out(node: NodeOnTrial) -> Outcome:
    longest_s = 0.0
    for command in node.talk.kind.commands:
        for _ in phases(node):
            node.talk.say(command.frame, node.acting(command.frame))
            said = _in_force(node, node.talk.listen(4.0 * MODULE_TIMEOUT_S), command)
            longest_s = max(longest_s, acting_s(said))
    return Outcome(
        longest_s <= MODULE_TIMEOUT_S + HALF_A_REPORT_S, f"one frame seen in force for {1e3 * longest_s:.0f} ms at most"
    )


@NODE.duty("N9", "A frame with a wrong CRC is refused", How.EXERCISE)
def _wrong_crc(node: NodeOnTrial) -> Outcome:
    return _refuses(node, lambda command: wrong_crc(_good(node, command)))


@NODE.duty("N10", "A frame with the CRC of another identifier is refused", How.EXERCISE)
def _crc_of_another(node: NodeOnTrial) -> Outcome:
    return _refuses(node, lambda command: crc_of_another(_good(node, command)))


@NODE.duty(
    "N11", "A frame whose counter is that of the one before is refused: repeating it holds nothing", How.EXERCISE
)
def _repeated(node: NodeOnTrial) -> Outcome:
    kept: dict[str, can.Message] = {}
    return _refuses(node, lambda command: kept.setdefault(command.frame, _good(node, command)))


@NODE.duty("N12", "A counter that skips is no error", How.EXERCISE)
def _skipping(node: NodeOnTrial) -> Outcome:
    def every_third(command: Command) -> can.Message:
        return [_good(node, command) for _ in range(3)][-1]

    for command in node.talk.kind.commands:
        said = _repeat(node, partial(every_third, command), command, 4.0 * MODULE_TIMEOUT_S)
        node.settle()
        if not said[-1][1]:
            return Outcome(False, f"{command.frame}: not in force with every third counter")
    return Outcome(True, "every third counter: in force")


@NODE.duty("N13", "A frame of fewer than 8 bytes is refused", How.EXERCISE)
def _short(node: NodeOnTrial) -> Outcome:
    return _refuses(node, lambda command: cut_short(_good(node, command)))
