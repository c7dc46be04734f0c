"""The remote site's session accepts the operator's own connections, and others within their rate."""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

import pytest

from common.faults.fault import Fault, FaultCode
from common.limits import GAP_S
from common.link.capabilities import capabilities
from common.link.curve import Received, Sender
from common.link.link import RemoteLink
from common.link.packet_filter import MOST_AHEAD
from common.timing.timeouts import MOTION_SILENCE_S
from common.wire.messages import motion_packet, pack_hand
from common.wire.packets import LinkState
from common.wire.session_messages import DESK_REQUESTS, REMOTE_DESK_REQUESTS, Answer, Heartbeat, Request
from remote_site.session.session_server import EXPELLED_S, PACKETS_AT_ONCE, SETTLED_NS, SILENCE_NS, SessionServer

MS = 1_000_000
TICK_NS = 2 * MS
OPERATOR, SECOND, OBSERVER = (name.ljust(40, "x") for name in ("operator", "second", "observer"))
ABLE = capabilities(("index",), 500.0, calibration="abc")
OWN, OTHER = 10, 20
"""Connection of the operator, and of somebody with a copy of its key."""


@dataclass
class Link:
    """What the server uses of its link; the test lets packets arrive."""

    coming: dict[str, list[Received]] = field(default_factory=lambda: defaultdict(list))
    answers: list[tuple[bytes, Answer]] = field(default_factory=list)
    beats: list[bytes] = field(default_factory=list)
    expelled: list[tuple[str, str, int, float]] = field(default_factory=list)
    forgiven: list[str] = field(default_factory=list)
    closed: set[int] = field(default_factory=set)

    def requests(self, stream: str) -> list[Received]:
        return self.coming.pop(stream, [])

    def newest_of_each(self, stream: str) -> list[Received]:
        return self.coming.pop(stream, [])

    def answer(self, stream: str, who: bytes, packet: bytes) -> None:
        if stream == "control":
            self.answers.append((who, Answer.decode(packet)))
        else:
            self.beats.append(who)

    def expel(self, stream: str, sender: Sender, refuse_s: float = 0.0) -> None:
        self.expelled.append((stream, sender.key, sender.connection, refuse_s))

    def forgive(self, key: str) -> None:
        self.forgiven.append(key)

    def is_open(self, stream: str, connection: int) -> bool:
        return connection not in self.closed

    def may_operate(self, key: str) -> bool:
        return key != OBSERVER


class Remote:
    """A session server, its honest operator, and all other senders of the test."""

    def __init__(self) -> None:
        self.link = Link()
        self.server = SessionServer(cast(RemoteLink, self.link), dict(ABLE), 0.15)
        self.now_ns = 10**12
        self.requests = self.motions = 0

    @property
    def ident(self) -> int:
        return self.server.session.ident

    @property
    def first_motion(self) -> int:
        return next(answer.details["first_motion"] for _, answer in self.link.answers if answer.session == self.ident)

    def arrive(self, stream: str, key: str, packet: bytes, connection: int = OWN) -> None:
        who = f"{key[:8]} {connection}".encode()
        self.link.coming[stream].append((Sender(who, key, connection), packet))

    def ask(
        self, verb: str, key: str = OPERATOR, connection: int = OWN, sequence: int | None = None, **given: Any
    ) -> None:
        self.requests += 1
        number = self.requests if sequence is None else sequence
        self.arrive("control", key, Request(self.ident, number, self.now_ns, verb, given).encode(), connection)

    def beat(self, key: str = OPERATOR, connection: int = OWN, offset_ns: int = 0) -> None:
        beat = Heartbeat(self.ident, 1, self.now_ns, LinkState.ENGAGED, self.now_ns, 0, offset_ns, MS)
        self.arrive("heartbeat", key, beat.encode(), connection)

    def move(
        self,
        x_m: float = 0.0,
        key: str = OPERATOR,
        connection: int = OWN,
        sequence: int | None = None,
        late_ns: int = 0,
        state: LinkState = LinkState.ENGAGED,
    ) -> None:
        """Send a motion; the operator numbers it, by default as its next one, from where the answer to hello says."""
        self.motions += sequence is None
        number = self.first_motion - 1 + self.motions if sequence is None else sequence
        hand = pack_hand(x_m, 0.0, [0.0] * 5)
        packet = motion_packet(self.ident, number, self.now_ns - late_ns, state, hand)
        self.arrive("motion", key, packet, connection)

    def step(self, ns: int = TICK_NS) -> None:
        self.now_ns += ns
        self.server.step(self.now_ns, "")

    def honest(self, ms: int = 100, state: LinkState = LinkState.ENGAGED) -> None:
        """The operator works for a time: a beat every 50 ms, a motion each tick."""
        for tick in range(ms // 2):
            if tick % 25 == 0:
                self.beat()
            self.move(state=state)
            self.step()

    def answered(self, verb_sequence: int) -> str:
        return next(answer.refused for _, answer in self.link.answers if answer.sequence == verb_sequence)


@pytest.fixture
def engaged() -> Remote:
    """An operator is engaged, and has not moved yet."""
    remote = Remote()
    remote.ask("hello", **ABLE, role="operator")
    remote.step()
    remote.beat()
    remote.ask("engage", max_age_s=0.15)
    remote.step()
    return remote


@pytest.fixture
def working(engaged: Remote) -> Remote:
    """An operator is engaged and moves."""
    engaged.honest()
    assert engaged.server.both_engaged
    return engaged


def x_m(remote: Remote) -> float:
    assert remote.server.motion is not None
    return remote.server.motion.rows[0].x_m


def test_motion_of_a_second_operator_moves_nothing_and_its_connection_is_ended(working: Remote) -> None:
    for ahead in range(50):
        working.move(0.17, key=SECOND, connection=OTHER, sequence=working.first_motion + working.motions + 100 * ahead)
        working.move()
        working.step()
        assert x_m(working) == 0.0
    assert working.link.expelled[0] == ("motion", SECOND, OTHER, EXPELLED_S)
    working.honest()
    assert working.server.acceptance.refused["sequence"] == working.server.acceptance.overtaken == 0
    assert working.server.both_engaged


def test_the_operator_continues_after_a_second_one_has_left(working: Remote) -> None:
    working.move(0.17, key=SECOND, connection=OTHER, sequence=9_000)
    working.step()
    working.honest()
    working.move(0.01)
    working.step()
    assert x_m(working) == pytest.approx(0.01)


def test_motion_before_hello_is_ignored_and_its_sender_may_still_become_the_operator() -> None:
    remote = Remote()
    for _ in range(20):
        remote.arrive("motion", OPERATOR, motion_packet(0, 1, remote.now_ns, LinkState.CONNECTED, bytes(60)))
        remote.step()
    assert remote.link.expelled == []
    remote.ask("hello", **ABLE, role="operator")
    remote.step()
    assert remote.link.forgiven == [OPERATOR]
    remote.beat()
    remote.step()
    remote.honest()
    assert remote.server.motion is not None


def test_an_operator_site_that_starts_again_right_after_its_hello_may_engage() -> None:
    remote = Remote()
    remote.ask("hello", sequence=5_000, **ABLE, role="operator")
    remote.step()
    ident = remote.ident
    remote.link.closed.add(OWN)
    remote.ask("hello", connection=OTHER, sequence=1, **ABLE, role="operator")
    remote.step()
    assert remote.ident == ident
    remote.beat(connection=OTHER)
    remote.ask("engage", connection=OTHER, sequence=2, max_age_s=0.15)
    remote.step()
    assert remote.answered(2) == ""
    assert remote.server.session.engaged


def test_an_answer_that_is_too_long_is_a_refusal_with_the_reason() -> None:
    remote = Remote()
    remote.server.capabilities["materials"] = ["x" * 40] * 200
    remote.ask("hello", **ABLE, role="operator")
    remote.step()
    assert "longer than" in remote.answered(1)
    remote.ask("status")
    remote.step()
    assert remote.answered(2) == ""


def test_a_copy_that_repeats_the_hello_does_not_lock_the_operator_out() -> None:
    remote = Remote()
    remote.ask("hello", **ABLE, role="operator")
    remote.step()
    remote.ask("hello", connection=OTHER, sequence=10**9, **ABLE, role="operator")
    remote.step()
    remote.beat()
    remote.ask("engage", max_age_s=0.15)
    remote.step()
    assert remote.server.session.engaged


@pytest.mark.parametrize("silent", [False, True], ids=["beside it", "while it is silent"])
@pytest.mark.parametrize(
    "guess",
    [
        lambda remote: 0,
        lambda remote: 1,
        lambda remote: remote.motions + 1,
        lambda remote: remote.first_motion - 1,
        lambda remote: remote.first_motion - 1 + remote.motions + MOST_AHEAD + 1,
        lambda remote: 2**63 - 1,
    ],
)
def test_a_copy_of_the_operators_key_moves_nothing_and_latches_a_fault_at_once(
    working: Remote, guess: Callable[[Remote], int], silent: bool
) -> None:
    """It knows the session's number, as all do who see touch, but not the first number of motion."""
    if silent:
        working.step(2 * round(GAP_S * 1e9))
    working.move(0.17, connection=OTHER, sequence=guess(working))
    working.step()
    assert x_m(working) == 0.0
    assert working.server.session.fault == Fault(FaultCode.KEY_USED_TWICE)
    assert working.link.expelled == [("motion", OPERATOR, OTHER, 0.0)]


def test_the_first_numbers_of_sessions_differ_and_only_the_operator_learns_them() -> None:
    found = set()
    for _ in range(20):
        remote = Remote()
        remote.ask("hello", **ABLE, role="operator")
        remote.step()
        remote.beat()
        found.add(remote.first_motion)
        remote.ask("hello", key=OBSERVER, connection=OTHER, **ABLE, role="observer")
        remote.ask("hello", connection=OTHER, **ABLE, role="operator")
        remote.step()
        answers = [answer for _, answer in remote.link.answers[1:]]
        assert [answer.refused for answer in answers] == [
            "",
            "another operator is connected: one operator per remote site",
        ]
        assert not any("first_motion" in answer.details for answer in answers)
    assert len(found) == 20
    assert max(found) > 2**40


def test_a_copy_gains_nothing_from_a_standstill_of_the_remote_site(working: Remote) -> None:
    for _ in range(5):
        working.now_ns += 3 * round(GAP_S * 1e9)
        working.move(0.17, connection=OTHER, sequence=50)
        working.move()
        working.beat(connection=OTHER, offset_ns=3_600_000 * MS)
        working.beat()
        working.step()
        assert x_m(working) == 0.0
    working.move(0.01)
    working.step()
    assert x_m(working) == pytest.approx(0.01), "its clock is the operator's still"


def test_an_operator_that_reconnects_is_no_copy(working: Remote) -> None:
    late = [working.first_motion + working.motions + ahead for ahead in (0, 1)]
    working.motions += 2
    for number in late:  # sent before the old connection broke, and on its way for long
        working.move(connection=OTHER)
        working.move(sequence=number, late_ns=60 * MS)
        working.step()
    working.link.closed.add(OWN)
    working.move(0.01, connection=OTHER)
    working.step()
    assert x_m(working) == pytest.approx(0.01)
    assert working.server.session.state is LinkState.ENGAGED
    assert working.link.expelled == []


def test_a_half_open_connection_delays_no_motion_on_a_new_one(working: Remote) -> None:
    working.move(0.01, connection=OTHER)
    working.step()
    assert x_m(working) == pytest.approx(0.01)
    assert working.server.session.state is LinkState.ENGAGED


def test_the_same_motion_on_two_connections_counts_once_and_the_later_copy_is_no_refusal(working: Remote) -> None:
    """Each connection is held back in turn, as by a lost segment, and its packets then come late and at once."""
    held: list[int] = []
    for tick in range(300):
        working.move(tick * 1e-6, connection=OWN if tick // 20 % 2 else OTHER)
        number = working.first_motion - 1 + working.motions
        held.append(number)
        if tick % 20 == 19:
            for late in held[-8:]:
                working.move(-0.1, connection=OTHER if tick // 20 % 2 else OWN, sequence=late, late_ns=200 * MS)
            held.clear()
        if tick % 25 == 0:
            working.beat()
        working.step()
        assert x_m(working) == pytest.approx(tick * 1e-6)
    acceptance = working.server.acceptance
    assert acceptance.refused == {}
    assert acceptance.overtaken == 15 * 8
    assert working.server.on_two_connections(working.now_ns)
    assert not working.server.on_two_connections(working.now_ns + 1100 * MS)
    assert working.server.both_engaged


@pytest.mark.parametrize("verb", ["engage", "disengage", "clear_fault", "annotate", "goodbye"])
def test_requests_of_a_copy_are_refused(working: Remote, verb: str) -> None:
    working.ask(verb, connection=OTHER, text="x", max_age_s=0.15)
    working.step()
    assert "asks on another connection" in working.answered(working.requests)
    assert working.server.both_engaged
    assert working.server.take_notes() == []


def test_requests_of_a_copy_block_no_request_of_the_operator(working: Remote) -> None:
    working.ask("disengage", connection=OTHER, sequence=10**9)
    working.ask("disengage")
    working.step()
    assert working.answered(working.requests) == ""
    assert working.server.session.state is LinkState.CONNECTED


def test_a_copys_heartbeat_changes_nothing_of_the_clock(working: Remote) -> None:
    for _ in range(20):
        working.beat(connection=OTHER, offset_ns=3600 * 10**9)
        working.move()
        working.step()
    assert working.server.both_engaged
    assert working.server.acceptance.refused == {}


@pytest.mark.parametrize(("connection", "sequence"), [(OWN, 0), (OTHER, 10**9), (OTHER, 0)])
def test_an_emergency_stop_of_the_operators_key_counts_from_any_connection_and_sequence(
    working: Remote, connection: int, sequence: int
) -> None:
    working.ask("estop", connection=connection, sequence=sequence)
    working.step()
    assert working.server.session.fault == Fault(FaultCode.OPERATOR_STOP)
    working.ask("clear_fault")
    working.step()
    assert working.server.session.state is LinkState.CONNECTED, "a stop does not use sequence numbers up"


@pytest.mark.parametrize("key", [SECOND, OBSERVER])
def test_an_emergency_stop_of_another_key_is_refused(working: Remote, key: str) -> None:
    working.ask("estop", key=key, connection=OTHER)
    working.step()
    assert working.server.session.state is LinkState.ENGAGED


def test_refused_motion_ends_an_engaged_session_with_the_reason(working: Remote) -> None:
    ident, sequence = working.ident, 0
    for tick in range(2000):
        sequence += 1
        if tick % 25 == 0:
            working.beat()
        working.move(sequence=working.first_motion)
        working.step()
        if not working.ident:
            break
    assert (SILENCE_NS - 10 * MS) < sequence * TICK_NS < SILENCE_NS + 100 * MS
    assert working.server.session.state is LinkState.DISCONNECTED
    who, ended = working.link.answers[-1]
    assert (who, ended.session, ended.sequence) == (b"operator 10", ident, 0)
    assert ended.refused == "motion has been refused for 1.5 s: overtaken"
    assert working.server.operator == ""


def test_a_pause_of_motion_after_a_late_copy_is_no_refusal(working: Remote) -> None:
    ident = working.ident
    working.move()
    working.step()
    working.move(connection=OTHER, sequence=working.first_motion - 1 + working.motions)
    for tick in range(2000):
        if tick % 25 == 0:
            working.beat()
        working.step()
    assert working.ident == ident


@pytest.mark.parametrize("verb", [*DESK_REQUESTS, *REMOTE_DESK_REQUESTS])
def test_a_request_for_a_desk_is_refused_over_the_link(working: Remote, verb: str) -> None:
    working.ask(verb)
    working.step()
    assert working.answered(working.requests).startswith("that is for ")


def test_the_age_that_one_session_agreed_on_does_not_hold_in_the_next(working: Remote) -> None:
    working.ask("disengage")
    working.ask("engage", max_age_s=0.05)
    working.step()
    assert working.server.acceptance.max_age_ns == 50 * MS
    working.ask("goodbye")
    working.step()
    working.ask("hello", **ABLE, role="operator")
    working.step()
    assert working.server.acceptance.max_age_ns == 150 * MS


@pytest.mark.parametrize("moved", [True, False])
def test_without_any_motion_an_engaged_session_is_reported_and_ends_up_disengaged(engaged: Remote, moved: bool) -> None:
    """As where a firewall blocks the port of motion, and heartbeats and touch pass."""
    if moved:
        engaged.honest()
    said = []
    for tick in range(round((MOTION_SILENCE_S - 0.1) * 500)):
        if tick % 25 == 0:
            engaged.beat()
        if tick in (1, 1000):
            engaged.ask("status")
        engaged.step()
        said += [answer.details["stale"] for _, answer in engaged.link.answers[-1:] if "stale" in answer.details]
        assert engaged.server.session.engaged
    assert list(dict.fromkeys(said)) == (["", "no motion for 2.00 s"] if moved else ["no motion has come yet"])
    engaged.beat()
    engaged.step(150 * MS)
    session = engaged.server.session
    assert (session.state, session.paused) == (LinkState.CONNECTED, "no motion for 5 s")
    engaged.ask("status")
    engaged.step()
    assert engaged.link.answers[-1][1].details["stale"] == ""


@pytest.mark.parametrize("stream", ["control", "heartbeat"])
@pytest.mark.parametrize("key", [SECOND, OBSERVER])
def test_a_flooding_client_is_refused_and_the_operator_is_served(working: Remote, stream: str, key: str) -> None:
    for _ in range(10):
        for _ in range(60):
            if stream == "control":
                working.ask("annotate", key=key, connection=OTHER, text="x")
            else:
                working.beat(key=key, connection=OTHER)
        working.move()
        working.step()
    assert working.link.expelled == [(stream, key, OTHER, EXPELLED_S)]
    assert working.server.expelled == {stream: 1}
    assert len(working.link.answers) <= PACKETS_AT_ONCE + 10
    working.ask("disengage")
    working.step()
    assert working.answered(working.requests) == ""


@pytest.mark.parametrize("stream", ["control", "heartbeat"])
def test_a_flooding_copy_takes_nothing_of_the_operators_rate(working: Remote, stream: str) -> None:
    for tick in range(1000):
        for _ in range(5):
            if stream == "control":
                working.ask("annotate", connection=OTHER, text="x")
            else:
                working.beat(connection=OTHER)
        if tick % 25 == 0:
            working.beat()
        working.move()
        working.step()
    assert set(working.link.expelled) == {(stream, OPERATOR, OTHER, 0.0)}
    assert working.server.both_engaged
    working.ask("disengage")
    working.step()
    assert working.answered(working.requests) == ""


def test_a_clock_that_is_set_back_keeps_no_session_of_a_silent_operator(working: Remote) -> None:
    working.now_ns -= 100 * 10**9
    for _ in range(SILENCE_NS // TICK_NS + 1):
        working.step()
        assert working.ident
    working.step()
    assert not working.ident


def test_an_engage_after_the_clock_was_set_back_is_granted(working: Remote) -> None:
    working.server.disengage(working.now_ns)
    working.now_ns -= 100 * 10**9
    working.step()
    working.ask("engage", max_age_s=0.15)
    working.step()
    assert working.answered(working.requests) == ""


def test_an_operators_site_that_is_no_longer_engaged_ends_it_here_after_a_grace_period(working: Remote) -> None:
    working.honest(5000)
    working.honest(SETTLED_NS // MS, LinkState.CONNECTED)
    assert working.server.session.engaged
    working.honest(100, LinkState.CONNECTED)
    assert working.server.session.state is LinkState.CONNECTED


def test_a_heartbeat_of_another_session_keeps_none_and_has_no_answer(working: Remote) -> None:
    working.link.beats.clear()
    for _ in range(0, SILENCE_NS + 200 * MS, 50 * MS):
        other = Heartbeat(working.ident + 1, 1, working.now_ns, LinkState.ENGAGED, working.now_ns, 0, 0, MS)
        working.arrive("heartbeat", OPERATOR, other.encode())
        working.step(50 * MS)
    assert not working.ident
    working.beat()
    working.step()
    assert working.link.beats == []


def test_an_observer_is_one_until_it_is_silent(working: Remote) -> None:
    working.ask("hello", key=OBSERVER, connection=OTHER, **ABLE, role="observer")
    for _ in range(0, 3 * SILENCE_NS, 50 * MS):
        working.beat(OBSERVER, OTHER)
        working.honest(50)
        assert list(working.server.observers) == [OBSERVER]
    assert working.link.beats.count(b"observer 20") == 3 * SILENCE_NS // (50 * MS)
    working.honest(SILENCE_NS // MS - 50)
    assert working.server.observers
    working.honest(100)
    assert working.server.observers == {}


def test_a_silence_of_motion_and_its_end_are_noted(working: Remote) -> None:
    working.server.session.take_happenings()
    working.beat()
    working.step(round(1.1 * GAP_S * 1e9))
    working.honest(10)
    said = [(happening.what, happening.text) for happening in working.server.session.take_happenings()]
    assert said == [("silent", "no motion for 100 ms"), ("heard", "motion again")]


def test_a_stop_within_the_operators_own_flood_acts_at_once(working: Remote) -> None:
    for _ in range(300):
        working.ask("annotate", text="not an estop")
    working.ask("estop")
    working.step()
    assert working.server.session.fault == Fault(FaultCode.OPERATOR_STOP)
    assert len(working.server.take_notes()) <= PACKETS_AT_ONCE
    assert set(working.link.expelled) == {("control", OPERATOR, OWN, 0.0)}
