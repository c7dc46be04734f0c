"""The two ends of a session against each other, over a real link on loopback, with clocks that the test sets."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

import numpy as np
import pytest

from common.keys import TrustedKeys, load_keys
from common.link import OperatorLink, RemoteLink
from common.messages import Touch
from common.packets import LinkState
from common.session_messages import Request
from operator_site.session_client import SessionClient
from remote_site.session_server import SessionServer

SECOND = 1_000_000_000
CLOCK_APART_NS = 7_200 * SECOND + 123
"""The two hosts were not started at the same time."""
TOUCH_NOTHING = np.zeros((5, 18), np.float32)
AT_REST = np.zeros((5, 3), np.float32)


class Keys(Protocol):
    remote: Path
    operator: Path


class Pair:
    """One remote site and one operator site, stepped by turns."""

    def __init__(self, keys: Keys, base_port: int, fingers: tuple[list[str], list[str]], engage: bool) -> None:
        remote_keys = load_keys(keys.remote)
        self.remote_link = RemoteLink("127.0.0.1", base_port, remote_keys, TrustedKeys(keys.remote))
        self.new_operator = lambda: OperatorLink("127.0.0.1", base_port, load_keys(keys.operator), remote_keys.public)
        self.operator_link = self.new_operator()
        self.server = SessionServer(self.remote_link, {"fingers": fingers[0]}, 0.15)
        self.client = SessionClient(self.operator_link, {"fingers": fingers[1]}, 0.15, engage)
        self.remote_shift_ns, self.operator_shift_ns = CLOCK_APART_NS, 0
        self.remote_missing = self.operator_missing = ""
        self.sequence = 0

    def remote_now(self) -> int:
        return time.monotonic_ns() + self.remote_shift_ns

    def operator_now(self) -> int:
        return time.monotonic_ns() + self.operator_shift_ns

    def turn_remote(self) -> None:
        self.server.step(self.remote_now(), self.remote_missing)
        session = self.server.session
        if session.ident:
            self.sequence += 1
            touch = Touch(session.ident, self.sequence, self.remote_now(), session.state, TOUCH_NOTHING, ("",) * 5, ())
            self.remote_link.send_latest("touch", touch.encode())

    def turn_operator(self) -> None:
        self.client.step(self.operator_now(), self.operator_missing)
        self.client.send_motion(self.operator_now(), AT_REST)

    def until(self, done: Callable[[], object], seconds: float = 8.0) -> None:
        deadline = time.monotonic() + seconds
        while not done():
            assert time.monotonic() < deadline, (self.server.session, self.client.session, self.client.refusal)
            self.turn_remote()
            self.turn_operator()
            time.sleep(0.001)  # leaves the processor to the sockets' own threads

    def ask(self, verb: str, text: str = "") -> None:
        self.client.request(verb, self.operator_now(), {"text": text})

    def close(self) -> None:
        self.operator_link.close()
        self.remote_link.close()


@pytest.fixture
def make(keys: Keys, base_port: int) -> Iterator[Callable[..., Pair]]:
    made: list[Pair] = []

    def make_pair(
        ours: tuple[str, ...] = ("index",), theirs: tuple[str, ...] = ("index",), engage: bool = True
    ) -> Pair:
        made.append(Pair(keys, base_port, (list(ours), list(theirs)), engage))
        return made[-1]

    yield make_pair
    for pair in made:
        pair.close()


def both_engaged(pair: Pair) -> bool:
    return pair.server.both_engaged and pair.client.both_engaged


def test_hello_then_engaged_on_both_sides_with_the_clocks_compared(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    assert pair.client.session.ident == pair.server.session.ident > 0
    clock = pair.client.clock
    assert clock.uncertainty_ns is not None
    assert abs(clock.offset_ns - CLOCK_APART_NS) <= clock.uncertainty_ns
    assert 0 <= pair.server.acceptance.age_ns < 0.15 * SECOND
    assert not pair.server.damaged
    assert not pair.client.damaged


def test_heartbeats_and_requests_are_not_counted_as_lost_motion(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: pair.server.acceptance.received > 50)
    received, lost = pair.server.acceptance.received, pair.server.acceptance.lost
    assert received + lost <= pair.client._motion_sequence
    assert pair.client._motion_sequence < received + lost + 50


def test_nobody_engages_who_was_not_asked_to(make: Callable[..., Pair]) -> None:
    pair = make(engage=False)
    pair.until(lambda: pair.server.motion is not None and pair.client.touch is not None)
    assert (pair.server.session.state, pair.client.session.state) == (LinkState.CONNECTED, LinkState.CONNECTED)
    pair.ask("engage")
    pair.until(lambda: both_engaged(pair))


@pytest.mark.parametrize("side", ["remote_missing", "operator_missing"])
def test_they_engage_only_when_both_are_ready(make: Callable[..., Pair], side: str) -> None:
    pair = make()
    setattr(pair, side, "index tacttip: opening")
    if side == "remote_missing":
        pair.until(lambda: pair.client.refusal == "not ready: index tacttip: opening")
    else:
        pair.until(lambda: pair.server.acceptance.received > 100)
    assert not pair.server.session.engaged
    assert not pair.client.session.engaged
    setattr(pair, side, "")
    pair.until(lambda: both_engaged(pair))
    assert pair.client.refusal == ""


def test_another_operator_is_refused_while_one_is_there(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    with pair.new_operator() as link:
        other = SessionClient(link, {"fingers": ["index"]}, 0.15, True)

        def other_is_told() -> bool:
            other.step(pair.operator_now(), "")
            return "another operator is connected" in other.refusal

        pair.until(other_is_told)
        assert other.session.ident == 0
    assert both_engaged(pair)


def test_different_fingers_are_refused(make: Callable[..., Pair]) -> None:
    pair = make(ours=("index",), theirs=("thumb", "index"))
    pair.until(lambda: "configure the same on both" in pair.client.refusal)
    assert (pair.server.session.ident, pair.client.session.ident) == (0, 0)


def test_a_hello_full_of_rubbish_is_refused_and_harms_nothing(make: Callable[..., Pair]) -> None:
    pair = make(engage=False)
    pair.client.capabilities = {"fingers": "x" * 3900}
    pair.until(lambda: "the operator has fingers xxx" in pair.client.refusal)
    assert len(pair.client.refusal) == 400
    pair.client.capabilities = {"fingers": ["index"]}
    pair.until(lambda: pair.client.session.ident)


def test_disengaging_brings_both_to_neutral(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.client.want_engaged = False
    pair.ask("disengage")
    pair.until(lambda: not pair.server.session.engaged and not pair.client.session.engaged)
    assert pair.server.session.state is LinkState.CONNECTED


def test_an_emergency_stop_latches_until_it_is_cleared_and_engaged_anew(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.ask("estop")
    pair.until(lambda: pair.server.session.state is LinkState.FAULT and not pair.client.session.engaged)
    pair.until(lambda: "a fault is latched (emergency stop)" in pair.client.refusal)
    assert not pair.server.both_engaged
    pair.client.want_engaged = False
    pair.ask("clear_fault")
    pair.until(lambda: pair.server.session.state is LinkState.CONNECTED)
    assert not pair.client.session.engaged
    pair.client.want_engaged = True
    pair.until(lambda: both_engaged(pair))


def test_silence_of_the_operator_ends_the_session_and_it_finds_back(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    first = pair.server.session.ident
    pair.remote_shift_ns += SECOND + 1
    pair.server.step(pair.remote_now(), "")
    assert (pair.server.session.ident, pair.server.session.state) == (0, LinkState.DISCONNECTED)
    pair.operator_shift_ns += SECOND + 1
    pair.until(lambda: both_engaged(pair))
    assert pair.server.session.ident != first


def test_silence_of_the_remote_site_ends_the_session_and_it_is_found_again(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    first = pair.client.session.ident
    pair.operator_shift_ns += SECOND + 1
    while pair.client.session.ident == first:  # answers already on their way may still come in
        pair.turn_operator()
        pair.operator_shift_ns += SECOND + 1
    assert not pair.client.session.engaged
    pair.remote_shift_ns += SECOND + 1
    pair.until(lambda: both_engaged(pair))
    assert pair.client.session.ident not in (0, first)


def test_a_fault_outlives_the_operator_and_the_next_one_can_clear_it(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.server.session.latch("plate too hot")
    pair.remote_shift_ns += SECOND + 1
    pair.server.step(pair.remote_now(), "")
    pair.operator_shift_ns += SECOND + 1
    first = pair.client.session.ident
    pair.until(lambda: pair.client.session.ident not in (0, first))
    assert pair.server.session.state is LinkState.FAULT
    pair.ask("clear_fault")
    pair.until(lambda: both_engaged(pair))


def test_requests_of_no_session_are_refused_and_remarks_are_kept(make: Callable[..., Pair]) -> None:
    pair = make(engage=False)
    pair.until(lambda: pair.client.session.ident)
    stale = Request(12345, 999_999, pair.operator_now(), "estop", {})
    pair.operator_link.send("control", stale.encode())
    pair.ask("annotate", "a rough spot")
    notes: list[str] = []

    def noted() -> bool:
        notes.extend(pair.server.take_notes())
        return bool(notes)

    pair.until(noted)
    assert notes == ["a rough spot"]
    assert pair.server.session.state is LinkState.CONNECTED


def test_damaged_packets_are_counted_on_every_stream(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    for stream in ("control", "heartbeat"):
        pair.operator_link.send(stream, b"\xc1rubbish")
    pair.until(lambda: pair.server.damaged["control"] and pair.server.damaged["heartbeat"])

    def rubbish_seen() -> bool:
        pair.operator_link.send_latest("motion", b"\xc1")
        time.sleep(0.001)
        return pair.server.damaged["motion"] > 0

    pair.until(rubbish_seen)
    pair.until(lambda: both_engaged(pair))
