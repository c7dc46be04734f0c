"""The two ends of a session against each other, with clocks that the test sets.

The link is one in memory on virtual time. Where keys matter it is a real one on loopback.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, cast

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
from common.wire.session_messages import ASKED_BEFORE, Answer, Request
from operator_site.session.session_client import SessionClient
from remote_site.session.local_control import answer_desk
from remote_site.session.session_server import SILENCE_NS, SessionServer
from teletaction.testbed.network import TO_REMOTE, Network, OperatorEnd, RemoteEnd
from tests.conftest import Keys

SECOND = 1_000_000_000
CLOCK_APART_NS = 7_200 * SECOND + 123
"""The two hosts were not started at the same time."""
HOT = Fault(FaultCode.SENSOR_PLATE_TOO_HOT, "index", value=42.3, limit=42.0)
TOUCH_NOTHING = TOUCH_BLOCK.to_bytes(np.zeros((5, len(TOUCH_FIELDS)), np.float32))
AT_REST = (0.0, 0.0, (0.0,) * 5)


def able(fingers: list[str]) -> dict[str, Any]:
    return capabilities(tuple(fingers), 500.0, calibration="abc")


class Pair:
    """One remote site and one operator site, stepped by turns.

    Attributes:
        wait: let some time pass, s.
    """

    def __init__(
        self,
        remote_link: RemoteLink,
        operator_link: OperatorLink,
        fingers: tuple[list[str], list[str]] = (["index"], ["index"]),
        engage: bool = True,
    ) -> None:
        self.remote_link, self.operator_link = remote_link, operator_link
        self.server = SessionServer(remote_link, able(fingers[0]), 0.15)
        self.client = SessionClient(operator_link, able(fingers[1]), 0.15, engage)
        self.remote_shift_ns, self.operator_shift_ns = CLOCK_APART_NS, 0
        self.remote_missing = self.operator_missing = ""
        self.remote_awake = ""
        self.sequence = 0
        self.now_ns: Callable[[], int] = time.monotonic_ns
        self.wait: Callable[[float], None] = time.sleep

    def remote_now(self) -> int:
        return self.now_ns() + self.remote_shift_ns

    def operator_now(self) -> int:
        return self.now_ns() + self.operator_shift_ns

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
        self.client.send_motion(self.operator_now(), *AT_REST)

    def turn(self) -> None:
        self.turn_remote()
        self.turn_operator()

    def until(self, done: Callable[[], object], turn: Callable[[], object] | None = None, seconds: float = 8.0) -> None:
        """Take turns, of both sites or as given, until something is reached."""
        deadline_ns = self.now_ns() + round(seconds * SECOND)
        while not done():
            assert self.now_ns() < deadline_ns, (self.server.session, self.client.session, self.client.refusal)
            (turn or self.turn)()
            self.wait(0.001)  # leaves the processor to the threads of real sockets

    def ask(self, verb: str, text: str = "") -> None:
        self.client.request(verb, self.operator_now(), {"text": text})


class MemoryPair(Pair):
    """A pair on virtual time."""

    def __init__(self, fingers: tuple[list[str], list[str]], engage: bool) -> None:
        self.network = network = Network(seed=0, now_s=1000.0)
        super().__init__(
            cast(RemoteLink, RemoteEnd(network)), cast(OperatorLink, OperatorEnd(network)), fingers, engage
        )

        def wait(seconds: float) -> None:
            network.now_s += seconds

        self.now_ns, self.wait = lambda: round(network.now_s * SECOND), wait


@pytest.fixture
def make() -> Callable[..., Pair]:
    """Makes pairs on virtual time."""

    def make_pair(
        ours: tuple[str, ...] = ("index",), theirs: tuple[str, ...] = ("index",), engage: bool = True
    ) -> Pair:
        return MemoryPair((list(ours), list(theirs)), engage)

    return make_pair


Connect = Callable[[Path, Role], OperatorLink]


@pytest.fixture
def connect(keys: Keys, base_port: int) -> Iterator[Connect]:
    """Connects a key folder with the remote site over a real link."""
    with ExitStack() as links:

        def link(folder: Path, role: Role) -> OperatorLink:
            made = OperatorLink("127.0.0.1", base_port, load_keys(folder), load_keys(keys.remote).public, role)
            return links.enter_context(made)

        yield link


@pytest.fixture
def real_pair(keys: Keys, base_port: int, connect: Connect) -> Iterator[Pair]:
    """A pair over a real link."""
    with RemoteLink("127.0.0.1", base_port, load_keys(keys.remote), TrustedKeys(keys.remote)) as remote_link:
        yield Pair(remote_link, connect(keys.operator, Role.PARTNER))


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
    sent = pair.client._motion_sequence - pair.server._first_motion + 1
    assert received + lost <= sent < received + lost + 60


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
        pair.wait(held_s)
        pair.turn_operator()  # its heartbeat leaves, and comes in, long after the tick began
        pair.wait(0.002)
        pair.server.step(began_ns, "")
        pair.wait(0.002)
        pair.client.step(pair.operator_now(), "")
    assert pair.client.clock.round_trip_ns != beats
    assert pair.client.clock.steps == 0
    assert pair.client.clock.uncertainty_ns is not None
    assert abs(pair.client.clock.offset_ns - CLOCK_APART_NS) <= pair.client.clock.uncertainty_ns


def test_another_operator_is_refused_while_one_is_there(real_pair: Pair, connect: Connect, keys: Keys) -> None:
    pair = real_pair
    pair.until(lambda: both_engaged(pair))
    other = SessionClient(connect(keys.operator, Role.PARTNER), able(["index"]), 0.15, True)

    def other_is_refused() -> bool:
        other.step(pair.operator_now(), "")
        return "another operator is connected" in other.refusal

    pair.until(other_is_refused)
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
    pair.wait(0.002)
    assert pair.remote_link.requests("control"), "taken, and so lost"
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
    pair.until(lambda: pair.server.session.ident == 0, pair.turn_remote)
    assert pair.server.session.state is LinkState.DISCONNECTED


def test_an_operator_who_lets_go_brings_the_remote_site_back_to_connected(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    pair.client.want_engaged = False
    pair.client.session.disengage()
    pair.until(lambda: not pair.server.both_engaged)
    pair.until(lambda: pair.server.session.state is LinkState.CONNECTED)


@pytest.mark.parametrize("before", ["engaged", "a fault", "connected"])
def test_an_engage_on_its_way_while_the_remote_site_stops_acting_has_no_effect(
    make: Callable[..., Pair], before: str
) -> None:
    """The operator's site repeats a request until it is granted, so that one may arrive late."""
    pair = make(engage=False)
    pair.until(lambda: pair.client.clock.uncertainty_ns)
    if before != "connected":
        pair.ask("engage")
        pair.until(lambda: both_engaged(pair))
    session = pair.server.session
    cast(MemoryPair, pair).network.impair(TO_REMOTE, "control", delay_s=0.1)
    pair.ask("engage")
    pair.turn()
    if before == "a fault":
        session.latch(HOT)
        pair.turn()
    answer_desk(pair.server, pair.remote_now(), "", "clear_fault" if before == "a fault" else "disengage")
    for _ in range(200):
        pair.turn()
        pair.wait(0.001)
        assert session.state is LinkState.CONNECTED
    pair.until(lambda: not pair.client.session.engaged)
    pair.ask("engage")
    pair.until(lambda: both_engaged(pair))


def test_a_persons_engage_that_came_too_late_is_not_repeated(make: Callable[..., Pair]) -> None:
    pair = make(engage=False)
    pair.client.engages_itself = False
    pair.until(lambda: pair.client.clock.uncertainty_ns)
    cast(MemoryPair, pair).network.impair(TO_REMOTE, "control", delay_s=0.1)
    pair.client.want_engaged = True
    pair.turn()
    answer_desk(pair.server, pair.remote_now(), "", "disengage")
    for _ in range(1000):
        pair.turn()
        pair.wait(0.001)
        assert pair.server.session.state is LinkState.CONNECTED
    assert not pair.client.want_engaged
    assert pair.client.refusal == ASKED_BEFORE
    pair.client.want_engaged = True
    pair.until(lambda: both_engaged(pair))


@pytest.mark.parametrize("side", ["remote", "operator"])
def test_a_disengage_ends_a_persons_engage_that_waits_for_a_device(make: Callable[..., Pair], side: str) -> None:
    pair = make(engage=False)
    pair.client.engages_itself = False
    pair.until(lambda: pair.client.clock.uncertainty_ns)
    setattr(pair, f"{side}_missing", "index thermal_sensor")
    pair.client.want_engaged = True
    for _ in range(300):
        pair.turn()
        pair.wait(0.001)
    answer_desk(pair.server, pair.remote_now(), pair.remote_missing, "disengage")
    pair.wait(0.001)
    setattr(pair, f"{side}_missing", "")
    pair.until(lambda: not pair.client.want_engaged)
    assert pair.client.refusal == ASKED_BEFORE
    assert not pair.server.session.engaged
    pair.client.want_engaged = True
    pair.until(lambda: both_engaged(pair))


def test_an_operator_without_touch_moves_nothing_and_stays_engaged(make: Callable[..., Pair]) -> None:
    pair = make()
    pair.until(lambda: both_engaged(pair))
    assert pair.client.acceptance.last_ns is not None
    pair.client.acceptance.last_ns -= SECOND // 5  # no packet came for 0.2 s

    def blind() -> bool:
        packet = pair.client.send_motion(pair.operator_now(), *AT_REST)
        assert packet is not None
        assert Motion.decode(packet).state is LinkState.CONNECTED
        pair.server.step(pair.remote_now(), "")
        return not pair.server.both_engaged

    pair.until(blind, lambda: None)
    pair.until(lambda: both_engaged(pair))
    assert [h.what for h in pair.server.session.take_happenings()] == ["connected", "engaged"]


def test_a_site_of_another_version_gets_the_reason(make: Callable[..., Pair]) -> None:
    pair = make(engage=False)
    pair.until(lambda: pair.client.session.ident)
    pair.operator_link.send("control", msgpack.packb([SCHEMA_VERSION + 1, 0, 1, 0, "hello", {}, "new"]))
    refused: list[str] = []

    def refused_by_version() -> bool:
        refused.extend(Answer.decode(packet).refused for packet in pair.operator_link.receive("control"))
        return any(f"speaks schema version {SCHEMA_VERSION}" in text for text in refused)

    pair.until(refused_by_version, pair.turn_remote)
    pair.client._answer(msgpack.packb([SCHEMA_VERSION + 1, 0, 1, 0, "", {}]), pair.operator_now())
    assert f"this side speaks {SCHEMA_VERSION}" in pair.client.refusal


class Onlooker:
    """An observer with a key of its own."""

    def __init__(self, pair: Pair, link: OperatorLink) -> None:
        self.pair, self.link = pair, link
        self.client = SessionClient(link, able([]), 0.15, False, role=OBSERVER)

    def sees(self) -> bool:
        self.client.step(self.pair.operator_now(), "")
        return self.client.touch is not None

    def is_refused(self, words: str) -> bool:
        return any(words in Answer.decode(packet).refused for packet in self.link.receive("control"))


@pytest.fixture
def onlooker(real_pair: Pair, connect: Connect, keys: Keys) -> Onlooker:
    """An observer that the remote site trusts under the name `student`."""
    TrustedKeys(keys.remote).trust("student", load_keys(keys.stranger).public, Role.OBSERVER)
    return Onlooker(real_pair, connect(keys.stranger, Role.OBSERVER))


def test_a_read_only_client_sees_the_same_touch_and_changes_nothing(real_pair: Pair, onlooker: Onlooker) -> None:
    pair = real_pair
    pair.until(lambda: both_engaged(pair))
    pair.until(onlooker.sees)
    assert onlooker.client.session.ident == pair.server.session.ident
    assert len(pair.server.observers) == 1
    for verb in ("engage", "disengage", "estop", "clear_fault", "annotate", "goodbye"):
        onlooker.client.request(verb, pair.operator_now(), {"text": "?", "max_age_s": 0.1})
        pair.until(lambda: onlooker.is_refused("observers look on"))
    onlooker.client.session.ident = 0
    onlooker.client.request("hello", pair.operator_now(), able(["index"]))
    pair.until(lambda: onlooker.is_refused("trusted as an observer's only"))
    assert both_engaged(pair)


def test_a_read_only_client_waits_for_an_operator_and_is_forgotten_when_gone(
    real_pair: Pair, onlooker: Onlooker
) -> None:
    pair = real_pair

    def waits() -> bool:
        onlooker.client.step(pair.operator_now(), "")
        return "no operator is connected" in onlooker.client.refusal

    pair.until(waits, pair.turn_remote)
    pair.until(onlooker.sees)
    pair.remote_shift_ns += SILENCE_NS + 1
    pair.server.step(pair.remote_now(), "")
    assert not pair.server.observers


def test_revoking_a_read_only_client_leaves_the_operator_connected(
    real_pair: Pair, onlooker: Onlooker, keys: Keys
) -> None:
    pair = real_pair
    pair.until(lambda: both_engaged(pair))
    pair.until(onlooker.sees)
    TrustedKeys(keys.remote).revoke("student")
    revoked = pair.remote_link.recheck_keys()
    pair.server.cut(revoked)
    assert revoked == {load_keys(keys.stranger).public}
    pair.until(lambda: not pair.remote_link.recheck_keys() and onlooker.link.key_refused())
    while onlooker.link.receive_latest("observed") is not None:
        pass  # what was under way
    received = pair.server.acceptance.received
    pair.until(lambda: pair.server.acceptance.received > received + 100)
    assert onlooker.link.receive_latest("observed") is None
    assert both_engaged(pair)
    TrustedKeys(keys.remote).trust("student", load_keys(keys.stranger).public, Role.OBSERVER)
    onlooker.link.reconnect()
    onlooker.client.touch = None
    pair.until(onlooker.sees)


def test_revoking_the_operator_ends_the_session_and_trust_restores_it(real_pair: Pair, keys: Keys) -> None:
    pair = real_pair
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
    assert pair.server.acceptance.refused["sequence"] == 0, "motion is counted from its beginning"


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
        return pair.server.damaged["motion"] > 0

    pair.until(rubbish_seen, pair.turn_remote)
    pair.until(lambda: both_engaged(pair))
