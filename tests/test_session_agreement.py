"""The two ends of a session against each other, over a real link on loopback, with clocks that the test sets."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Protocol

import msgpack
import numpy as np
import pytest

from common.faults.fault import Fault, FaultCode
from common.link.capabilities import OBSERVER, capabilities
from common.link.keys import Role, TrustedKeys, load_keys
from common.link.link import OperatorLink, RemoteLink
from common.link.packet_filter import FUTURE_TOLERANCE_NS
from common.wire.messages import TOUCH_BLOCK, TOUCH_FIELDS, Motion, Touch
from common.wire.packets import SCHEMA_VERSION, LinkState
from common.wire.session_messages import Answer, Request
from operator_site.session.session_client import SessionClient
from remote_site.session.session_server import SILENCE_NS, SessionServer

SECOND = 1_000_000_000
CLOCK_APART_NS = 7_200 * SECOND + 123
"""The two hosts were not started at the same time."""
HOT = Fault(FaultCode.SENSOR_PLATE_TOO_HOT, "index", value=42.3, limit=42.0)
TOUCH_NOTHING = TOUCH_BLOCK.to_bytes(np.zeros((5, len(TOUCH_FIELDS)), np.float32))
AT_REST = np.zeros((5, 3), np.float32)


class Keys(Protocol):
    remote: Path
    operator: Path
    stranger: Path


def able(fingers: list[str]) -> dict[str, Any]:
    return capabilities(tuple(fingers), 500.0, calibration="abc")


class Pair:
    """One remote site and one operator site, stepped by turns."""

    def __init__(self, keys: Keys, base_port: int, fingers: tuple[list[str], list[str]], engage: bool) -> None:
        remote_keys = load_keys(keys.remote)
        self.remote_link = RemoteLink("127.0.0.1", base_port, remote_keys, TrustedKeys(keys.remote))
        self.new_operator = lambda: OperatorLink("127.0.0.1", base_port, load_keys(keys.operator), remote_keys.public)
        self.operator_link = self.new_operator()
        self.server = SessionServer(self.remote_link, able(fingers[0]), 0.15)
        self.client = SessionClient(self.operator_link, able(fingers[1]), 0.15, engage)
        self.remote_shift_ns, self.operator_shift_ns = CLOCK_APART_NS, 0
        self.remote_missing = self.operator_missing = ""
        self.remote_awake = ""
        self.keys, self.base_port = keys, base_port
        self.sequence = 0

    def remote_now(self) -> int:
        return time.monotonic_ns() + self.remote_shift_ns

    def operator_now(self) -> int:
        return time.monotonic_ns() + self.operator_shift_ns

    def turn_remote(self) -> None:
        self.server.step(self.remote_now(), self.remote_missing, lambda _: {"index thermal_sensor": self.remote_awake})
        session = self.server.session
        if session.ident:
            self.sequence += 1
            touch = Touch(session.ident, self.sequence, self.remote_now(), session.state, TOUCH_NOTHING, ("",) * 5, ())
            self.remote_link.send_latest("touch", touch.encode())
            self.remote_link.send_latest("observed", touch.encode())

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
    assert -clock.uncertainty_ns - FUTURE_TOLERANCE_NS <= pair.server.acceptance.age_ns < 0.15 * SECOND
    assert not pair.server.damaged
    assert not pair.client.damaged


def test_heartbeats_and_requests_are_not_counted_as_lost_motion(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: pair.server.acceptance.received > 50)
    received, lost = pair.server.acceptance.received, pair.server.acceptance.lost
    assert received + lost <= pair.client._motion_sequence
    assert pair.client._motion_sequence < received + lost + 50


def test_a_site_engages_only_on_request(make: Callable[..., Pair]) -> None:
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


def test_a_tick_that_begins_long_before_it_reads_does_not_make_the_clocks_contradict(make: Callable[..., Pair]) -> None:
    """Heartbeats that come in while a tick is held up are stamped when they are read, not when the tick began."""
    pair = make()
    pair.server.stamp_ns, pair.client.stamp_ns = pair.remote_now, pair.operator_now
    pair.until(lambda: both_engaged(pair))
    beats = pair.client.clock.round_trip_ns
    for held_s in [0.06, 0.0, 0.0] * 8:
        began_ns = pair.remote_now()
        time.sleep(held_s)
        pair.turn_operator()  # its heartbeat leaves, and comes in, long after the tick began
        time.sleep(0.002)
        pair.server.step(began_ns, "")
        time.sleep(0.002)
        pair.client.step(pair.operator_now(), "")
    assert pair.client.clock.round_trip_ns != beats
    assert pair.client.clock.steps == 0
    assert pair.client.clock.uncertainty_ns is not None
    assert abs(pair.client.clock.offset_ns - CLOCK_APART_NS) <= pair.client.clock.uncertainty_ns


def test_another_operator_is_refused_while_one_is_there(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    with pair.new_operator() as link:
        other = SessionClient(link, able(["index"]), 0.15, True)

        def other_is_informed() -> bool:
            other.step(pair.operator_now(), "")
            return "another operator is connected" in other.refusal

        pair.until(other_is_informed)
        assert other.session.ident == 0
    assert both_engaged(pair)


def test_different_fingers_are_refused(make: Callable[..., Pair]) -> None:
    pair = make(ours=("index",), theirs=("thumb", "index"))
    pair.until(lambda: "configure the same" in pair.client.refusal)
    assert (pair.server.session.ident, pair.client.session.ident) == (0, 0)


def test_a_hello_of_random_values_is_refused_and_does_no_harm(make: Callable[..., Pair]) -> None:
    pair = make(engage=False)
    pair.client.capabilities = able(["index"]) | {"fingers": "x" * 3800}
    pair.until(lambda: "the far side has fingers xxx" in pair.client.refusal)
    assert len(pair.client.refusal) == 400
    pair.client.capabilities = able(["index"])
    pair.until(lambda: pair.client.session.ident)


def test_disengaging_brings_both_to_neutral(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.client.want_engaged = False
    pair.ask("disengage")
    pair.until(lambda: not pair.server.session.engaged and not pair.client.session.engaged)
    assert pair.server.session.state is LinkState.CONNECTED


def test_an_emergency_stop_latches_both_until_it_is_cleared_and_engaged_again(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.client.stop(pair.operator_now())
    assert not pair.client.session.engaged
    pair.until(lambda: pair.server.session.state is LinkState.FAULT)
    pair.until(lambda: pair.client.remote_fault == Fault(FaultCode.OPERATOR_STOP))
    pair.until(lambda: pair.client.stopped.count("confirmed by every device") == 2)
    assert "confirmed by every device" in pair.server.stopped
    assert not pair.client.want_engaged, "engaging again must be asked for"
    pair.client.clear(pair.operator_now())
    pair.until(lambda: pair.server.session.state is LinkState.CONNECTED)
    pair.until(lambda: pair.client.remote_fault is None)
    assert pair.client.session.state is LinkState.CONNECTED
    for _ in range(100):
        pair.turn_remote()
        pair.turn_operator()
    assert not both_engaged(pair)
    pair.client.want_engaged = True
    pair.until(lambda: both_engaged(pair))


def test_an_emergency_stop_is_answered_when_the_devices_confirm_and_names_those_that_do_not(
    make: Callable[..., Pair],
) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.remote_awake = "no report"
    pair.client.stop(pair.operator_now())
    pair.until(lambda: pair.server.stopped)
    assert "not confirmed within" in pair.server.stopped
    assert "index thermal_sensor" in pair.server.stopped
    texts: list[str] = []

    def remote_informed() -> bool:
        texts.extend(h.text for h in pair.client.session.take_happenings() if h.what == "estop")
        return any("not confirmed by index thermal_sensor" in text for text in texts)

    pair.until(remote_informed)
    assert pair.server.session.state is LinkState.FAULT


def test_an_emergency_stop_is_repeated_until_the_remote_site_answers(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.client.stop(pair.operator_now())
    pair.turn_operator()
    for _ in pair.remote_link.requests("control"):
        pass  # lost
    pair.operator_shift_ns += SECOND // 4
    pair.until(lambda: pair.server.session.state is LinkState.FAULT)


def test_a_fault_of_the_remote_site_is_cleared_there(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.server.stop(pair.remote_now(), here=True)
    pair.until(lambda: pair.client.remote_fault == Fault(FaultCode.REMOTE_STOP))
    assert not pair.client.both_engaged
    pair.client.clear(pair.operator_now())
    pair.until(lambda: "to be cleared where it was latched" in pair.client.refusal)
    assert pair.server.session.state is LinkState.FAULT
    pair.server.session.clear()
    pair.until(lambda: pair.client.remote_fault is None)
    pair.client.want_engaged = True
    pair.until(lambda: both_engaged(pair))


@pytest.mark.parametrize(("ours", "theirs", "agreed"), [(0.15, 0.5, 0.15), (0.4, 0.2, 0.2)])
def test_the_stricter_age_is_agreed_on(make: Callable[..., Pair], ours: float, theirs: float, agreed: float) -> None:
    pair = make()
    pair.server.max_age_s, pair.client.max_age_s = ours, theirs
    pair.until(lambda: both_engaged(pair))
    assert pair.server.acceptance.max_age_ns == pair.client.acceptance.max_age_ns == agreed * SECOND


def test_a_foreign_calibration_is_refused_by_the_operators_site(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.client.calibration = "def"
    pair.until(lambda: "the remote site is calibrated with abc, this site expects def" in pair.client.refusal)
    assert pair.client.session.ident == 0
    pair.until(lambda: pair.server.session.ident == 0)
    pair.client.calibration = "abc"
    pair.until(lambda: both_engaged(pair))


def test_after_a_goodbye_the_next_operator_need_not_wait(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.client.goodbye(pair.operator_now())
    while pair.server.session.ident:
        pair.turn_remote()
    assert pair.server.session.state is LinkState.DISCONNECTED


def test_an_operator_who_lets_go_brings_the_remote_site_back_to_connected(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.client.want_engaged = False
    pair.client.session.disengage()
    pair.until(lambda: not pair.server.both_engaged)
    pair.until(lambda: pair.server.session.state is LinkState.CONNECTED)


def test_an_operator_without_touch_moves_nothing_and_stays_engaged(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    assert pair.client.acceptance.last_ns is not None
    pair.client.acceptance.last_ns -= SECOND // 5  # no packet came for 0.2 s

    def blind() -> bool:
        packet = pair.client.send_motion(pair.operator_now(), AT_REST)
        assert packet is not None
        assert Motion.decode(packet).state is LinkState.CONNECTED
        pair.server.step(pair.remote_now(), "")
        return not pair.server.both_engaged

    deadline_s = time.monotonic() + 8.0
    while not blind():
        assert time.monotonic() < deadline_s
        time.sleep(0.001)
    pair.until(lambda: both_engaged(pair))
    assert [h.what for h in pair.server.session.take_happenings()] == ["connected", "engaged"]


def test_a_site_of_another_version_gets_the_reason(make: Callable[..., Pair]) -> None:
    pair = make(engage=False)
    pair.until(lambda: pair.client.session.ident)
    pair.operator_link.send("control", msgpack.packb([SCHEMA_VERSION + 1, 0, 1, 0, "hello", {}, "new"]))
    refused, deadline_s = "", time.monotonic() + 8.0
    while f"speaks schema version {SCHEMA_VERSION}" not in refused:
        assert time.monotonic() < deadline_s
        pair.turn_remote()
        refused += "".join(Answer.decode(packet).refused for packet in pair.operator_link.receive("control"))
        time.sleep(0.001)
    pair.client._answer(msgpack.packb([SCHEMA_VERSION + 1, 0, 1, 0, "", {}]), pair.operator_now())
    assert f"this side speaks {SCHEMA_VERSION}" in pair.client.refusal


class Onlooker:
    """An observer with a key of its own."""

    def __init__(self, pair: Pair, folder: Path, role: Role = Role.OBSERVER) -> None:
        remote = load_keys(pair.keys.remote)
        self.link = OperatorLink("127.0.0.1", pair.base_port, load_keys(folder), remote.public, role)
        self.client = SessionClient(self.link, able([]), 0.15, False, role=OBSERVER)
        self.pair = pair

    def sees(self) -> bool:
        self.client.step(self.pair.operator_now(), "")
        return self.client.touch is not None

    def is_refused(self, words: str) -> bool:
        return any(words in Answer.decode(packet).refused for packet in self.link.receive("control"))


@pytest.fixture
def onlooker(keys: Keys) -> Iterator[Callable[[Pair], Onlooker]]:
    made: list[Onlooker] = []

    def look_on(pair: Pair) -> Onlooker:
        TrustedKeys(keys.remote).trust("student", load_keys(keys.stranger).public, Role.OBSERVER)
        made.append(Onlooker(pair, keys.stranger))
        return made[-1]

    yield look_on
    for observer in made:
        observer.link.close()


def test_a_read_only_client_sees_the_same_touch_and_changes_nothing(
    make: Callable[..., Pair], onlooker: Callable[[Pair], Onlooker]
) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    observer = onlooker(pair)
    pair.until(observer.sees)
    assert observer.client.session.ident == pair.server.session.ident
    assert len(pair.server.observers) == 1
    for verb in ("engage", "disengage", "estop", "clear_fault", "annotate", "goodbye"):
        observer.client.request(verb, pair.operator_now(), {"text": "?", "max_age_s": 0.1})
        pair.until(lambda: observer.is_refused("observers look on"))
    observer.client.session.ident = 0
    observer.client.request("hello", pair.operator_now(), able(["index"]))
    pair.until(lambda: observer.is_refused("trusted as an observer's only"))
    assert both_engaged(pair)


def test_a_read_only_client_waits_for_an_operator_and_is_forgotten_when_gone(
    make: Callable[..., Pair], onlooker: Callable[[Pair], Onlooker]
) -> None:
    pair = make(engage=False)
    observer = onlooker(pair)

    def waits() -> bool:
        observer.client.step(pair.operator_now(), "")
        pair.turn_remote()
        return "no operator is connected" in observer.client.refusal

    deadline_s = time.monotonic() + 8.0
    while not waits():
        assert time.monotonic() < deadline_s
        time.sleep(0.001)
    pair.until(observer.sees)
    pair.remote_shift_ns += SILENCE_NS + 1
    pair.server.step(pair.remote_now(), "")
    assert not pair.server.observers


def test_revoking_a_read_only_client_leaves_the_operator_connected(
    make: Callable[..., Pair], onlooker: Callable[[Pair], Onlooker], keys: Keys
) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    observer = onlooker(pair)
    pair.until(observer.sees)
    TrustedKeys(keys.remote).revoke("student")
    revoked = pair.remote_link.recheck_keys()
    pair.server.cut(revoked)
    assert revoked == {load_keys(keys.stranger).public}
    pair.until(lambda: not pair.remote_link.recheck_keys() and observer.link.key_refused())
    while observer.link.receive_latest("observed") is not None:
        pass  # what was under way
    received = pair.server.acceptance.received
    pair.until(lambda: pair.server.acceptance.received > received + 100)
    assert observer.link.receive_latest("observed") is None
    assert both_engaged(pair)
    TrustedKeys(keys.remote).trust("student", load_keys(keys.stranger).public, Role.OBSERVER)
    observer.link.reconnect()
    observer.client.touch = None
    pair.until(observer.sees)


def test_revoking_the_operator_ends_the_session_and_trust_restores_it(make: Callable[..., Pair], keys: Keys) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    TrustedKeys(keys.remote).revoke("operator")
    pair.server.cut(pair.remote_link.recheck_keys())
    assert pair.server.session.ident == 0
    pair.until(lambda: pair.remote_link.recheck_keys() or pair.operator_link.key_refused())
    assert pair.server.session.ident == 0
    while pair.operator_link.receive_latest("touch") is not None:
        pass
    pair.remote_link.send_latest("touch", b"secret")
    pair.turn_operator()
    assert pair.operator_link.receive_latest("touch") is None
    TrustedKeys(keys.remote).trust("operator", load_keys(keys.operator).public)
    pair.operator_link.reconnect()
    pair.operator_shift_ns += SILENCE_NS + 1
    pair.until(lambda: both_engaged(pair))


def test_a_silent_operator_ends_the_session_and_can_return(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    first = pair.server.session.ident
    pair.remote_shift_ns += SILENCE_NS + 1
    pair.server.step(pair.remote_now(), "")
    assert (pair.server.session.ident, pair.server.session.state) == (0, LinkState.DISCONNECTED)
    pair.operator_shift_ns += SILENCE_NS + 1
    pair.until(lambda: both_engaged(pair))
    assert pair.server.session.ident != first


def test_a_silent_remote_site_ends_the_session_and_is_found_again(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    first = pair.client.session.ident
    pair.operator_shift_ns += SILENCE_NS + 1
    while pair.client.session.ident == first:  # answers already on their way may still come in
        pair.turn_operator()
        pair.operator_shift_ns += SILENCE_NS + 1
    assert not pair.client.session.engaged
    pair.remote_shift_ns += SILENCE_NS + 1
    pair.until(lambda: both_engaged(pair))
    assert pair.client.session.ident not in (0, first)


def test_a_fault_outlives_the_operator_and_the_next_one_can_clear_it(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.server.session.latch(HOT)
    pair.remote_shift_ns += SILENCE_NS + 1
    pair.server.step(pair.remote_now(), "")
    pair.operator_shift_ns += SILENCE_NS + 1
    first = pair.client.session.ident
    pair.until(lambda: pair.client.session.ident not in (0, first))
    assert pair.server.session.state is LinkState.FAULT
    pair.until(lambda: pair.client.remote_fault == HOT)
    pair.ask("clear_fault")
    pair.until(lambda: pair.client.touch is not None and pair.client.touch.state is LinkState.CONNECTED)
    pair.client.want_engaged = True
    pair.until(lambda: both_engaged(pair))


def test_requests_without_a_session_are_refused_and_notes_are_kept(make: Callable[..., Pair]) -> None:
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
