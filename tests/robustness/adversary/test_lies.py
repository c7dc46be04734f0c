"""False packets of a peer that decoders accept: limits and hold times hold, and no site contains an exception."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from common.wire.messages import EVENT_MAX, TOUCH_BLOCK, TOUCH_HIGH, TOUCH_LOW, Event, EventKind, Touch
from common.wire.packets import MAX_INTEGER, MAX_TEXT, LinkState
from common.wire.session_messages import Answer, Heartbeat
from tests.virtual.session import VirtualSession

pytestmark = pytest.mark.long

LIE_S = 2.5
"""Longer than a session lives whose motion is refused."""
HOUR_NS = 3600 * 10**9
_INDEX = 1
ENDS, WORKS = "motion has been refused for 1.5 s", ""

BeatLie = Callable[[Heartbeat, float], Heartbeat]
CLOCK_LIES: dict[str, tuple[BeatLie, str]] = {
    "an hour ahead": (lambda beat, _: replace(beat, offset_ns=beat.offset_ns + HOUR_NS), ENDS),
    "an hour behind": (lambda beat, _: replace(beat, offset_ns=beat.offset_ns - HOUR_NS), ENDS),
    "the largest offset": (lambda beat, _: replace(beat, offset_ns=2**63 - 1), ENDS),
    "jumps by 1 s": (lambda beat, t: replace(beat, offset_ns=beat.offset_ns + round(t * 20) % 2 * 10**9), WORKS),
    "drifts by 1000 ppm": (lambda beat, t: replace(beat, offset_ns=beat.offset_ns + round(t * 1e6)), WORKS),
    "no uncertainty": (lambda beat, _: replace(beat, uncertainty_ns=0), ENDS),
    "the largest uncertainty": (lambda beat, _: replace(beat, uncertainty_ns=MAX_INTEGER), ENDS),
}
"""What the operator says of its clock, and how its session ends; empty where it does not."""


@pytest.mark.parametrize("lie", CLOCK_LIES)
def test_a_wrong_clock_of_the_operator_is_harmless_or_ends_the_session_with_the_reason(
    shared: VirtualSession, lie: str
) -> None:
    change, ends = CLOCK_LIES[lie]
    link: Any = shared.operator.client.link
    send, begin_s, ident = link.send, shared.time_s, shared.remote.server.session.ident

    def lying(stream: str, packet: bytes) -> bool:
        if stream == "heartbeat":
            packet = change(Heartbeat.decode(packet), shared.time_s - begin_s).encode()
        return bool(send(stream, packet))

    link.send = lying
    said = set()
    for _ in range(round(LIE_S / shared.step_s)):
        shared.tick()
        said.add(shared.operator.client.refusal.partition(":")[0])
    link.send = send
    assert said - {""} == ({ends} if ends else set())
    assert (shared.remote.server.session.ident == ident) == (not ends)
    assert shared.remote.contain.count == 0
    shared.until(lambda session: session.both_engaged, 5.0)


def _row(values: Any) -> bytes:
    return TOUCH_BLOCK.to_bytes(np.tile(values, (5, 1)).astype(np.float32))


def _events(touch: Touch, ident: int, value: float) -> tuple[Event, ...]:
    kinds = (EventKind.TAP, EventKind.GROOVE, EventKind.MATERIAL)
    return tuple(
        Event(ident + kind, kind, _INDEX, touch.time_ns, 0, value, "x" * MAX_TEXT if kind == EventKind.MATERIAL else "")
        for kind in kinds
    )


TouchLie = Callable[[Touch, int], Touch]
TOUCH_LIES: dict[str, TouchLie] = {
    "events once": lambda touch, n: touch._replace(events=_events(touch, 10_000 + 10 * n, 1.0)),
    "ids that go backwards": lambda touch, n: touch._replace(events=_events(touch, 10**9 - 10 * n, 1.0)),
    "the largest strengths": lambda touch, n: touch._replace(events=_events(touch, 2 * 10**9 + 10 * n, EVENT_MAX)),
    "rows at their upper limits": lambda touch, n: touch._replace(floats=_row(TOUCH_HIGH)),
    "rows at their lower limits": lambda touch, n: touch._replace(floats=_row(TOUCH_LOW)),
    "rows that jump": lambda touch, n: touch._replace(floats=_row(TOUCH_HIGH if n % 2 else TOUCH_LOW)),
    "a state that flaps": lambda touch, n: touch._replace(state=LinkState(n % len(LinkState))),
    "faults without end": lambda touch, n: touch._replace(state=LinkState.FAULT),
}


@pytest.mark.parametrize("lie", TOUCH_LIES)
def test_false_packets_of_the_remote_site_drive_no_actuator_beyond_its_limits(shared: VirtualSession, lie: str) -> None:
    perception: Any = shared.remote.perception
    packet, count = perception.packet, 0

    def lying(*given: Any) -> Touch:
        nonlocal count
        count += 1
        return TOUCH_LIES[lie](packet(*given), count)

    perception.packet = lying
    shared.run(0.5)
    perception.packet = packet
    assert count > 50
    assert shared.operator.contain.count == 0
    shared.run(0.3)
    shared.clear_faults()
    shared.run(0.3)
    shared.engage()
    shared.until(lambda session: session.both_engaged, 5.0)


def test_unrequested_answers_change_nothing(shared: VirtualSession) -> None:
    link: Any = shared.remote.server.link
    client = shared.operator.client
    ident, remote = client.session.ident, dict(client.remote)
    figures = {"session": ident + 1, "calibration": "another", "max_age_s": 0.5, "fingers": [], "fault": "made up"}
    for number in range(50):
        for session, sequence, refused in (
            (ident + 1, 0, "ended"),
            (0, 0, "ended"),
            (ident, number, ""),
            (ident, 10**9 + number, "refused"),
        ):
            link.answer("control", b"operator", Answer(session, sequence, 1, refused, figures).encode())
        shared.tick()
    assert client.session.ident == ident
    assert client.remote == remote
    assert not client.remote_fault
    link.answer("control", b"operator", Answer(ident, 0, 1, "the remote site ends it", {}).encode())
    shared.until(lambda session: client.refusal == "the remote site ends it", 0.1)
    shared.until(lambda session: session.both_engaged, 8.0)


HELLO_LIES: dict[str, tuple[dict[str, Any], str]] = {
    "other fingers": ({"fingers": ["thumb"]}, "the far side has fingers"),
    "another layout": ({"layout": "another"}, "touch is laid out differently"),
    "no rate": ({"rate_hz": "often"}, "far side's rate_hz"),
}


@pytest.mark.parametrize("lie", HELLO_LIES)
def test_a_remote_site_with_a_changing_hello_is_refused(shared: VirtualSession, lie: str) -> None:
    server: Any = shared.remote.server
    details, why = HELLO_LIES[lie]
    honest = dict(server.capabilities)
    hello = server._hello

    def lying(*given: Any) -> dict[str, Any]:
        return {**hello(*given), **details}

    shared.network.impair(cut=True)
    shared.run(2.0)
    type(server)._hello, kept = lambda self, *given: lying(*given), type(server)._hello
    try:
        shared.network.heal()
        shared.run(1.0)
        assert not shared.both_engaged
        assert shared.operator.client.refusal.startswith(why) or why in shared.operator.client.refusal
        assert (shared.now.force_n, shared.now.motor_mv) == (0.0, 0)
    finally:
        type(server)._hello = kept
    assert server.capabilities == honest
    shared.until(lambda session: session.both_engaged, 8.0)
