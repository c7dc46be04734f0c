"""One direction of one connection, in virtual time: TCP's promises hold whatever the network does to it."""

import math
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_sensors.network.conditions import TIMEOUT_MARGIN_S, Conditions, phased
from sim_sensors.network.path import QUEUE_BYTES, NetworkPath
from sim_sensors.network.stream import LATER_SEGMENTS, REORDERING, SEGMENT_BYTES, WINDOW_BYTES, TcpStream

FAR_S = 1e6
SOON_S = 1e-9


class Chances(Random):
    """Draws what it is given, then 1: never lost."""

    def __init__(self, *draws: float) -> None:
        super().__init__(0)
        self.draws = list(draws)

    def random(self) -> float:
        return self.draws.pop(0) if self.draws else 1.0


def stream(conditions: Conditions, random: Random | None = None) -> TcpStream:
    return TcpStream(NetworkPath(lambda _: conditions), random or Random(0))


def losing(delay_s: float, draws: list[float], again: list[float] | None = None) -> TcpStream:
    """Lose a segment whose draw is below 0.5: `draws` at its first try, `again` at the next ones."""
    tcp = stream(Conditions(delay_s, loss=0.5), Chances(0.0, *draws))
    tcp._again = Chances(*again or [])
    return tcp


@st.composite
def conditions(draw: st.DrawFn) -> Conditions:
    delay_s = draw(st.floats(0.0, 0.5))
    return Conditions(
        delay_s,
        delay_s * draw(st.floats(0.0, 1.0)),
        draw(st.sampled_from([0.0, 0.01, 0.5])),
        draw(st.sampled_from([math.inf, 1e6, 64e3])),
    )


spans = st.lists(st.tuples(st.floats(0.0, 3.0), st.floats(0.01, 2.0)), max_size=3)
sendings = st.lists(st.tuples(st.floats(0.0, 0.3), st.binary(min_size=1, max_size=3 * SEGMENT_BYTES)), max_size=20)
STEPS_S = [0.001 * n for n in range(1, 12_000, 7)]


@st.composite
def networks(draw: st.DrawFn) -> tuple[NetworkPath, float]:
    """A path that changes once and fails at times, and the shortest time that it ever takes."""
    phases = [draw(conditions()), draw(conditions())]
    path = NetworkPath(phased([0.0, draw(st.floats(0.1, 2.0))], phases))
    for start_s, seconds in draw(spans):
        path.stalls.add(start_s, seconds)
    for start_s, seconds in draw(spans):
        path.partitions.add(start_s, seconds)
    return path, min(phase.delay_s - phase.jitter_s for phase in phases)


def run(path: NetworkPath, sent: list[tuple[float, bytes]], steps_s: list[float]) -> list[tuple[float, int, int]]:
    """Send and take alternately; at each step the time, and how much was sent and has arrived by then."""
    tcp = TcpStream(path, Random(7))
    waiting, seen, arrived, count = list(sent), [], b"", 0
    everything = b"".join(data for _, data in sent)
    for now_s in [*steps_s, FAR_S]:
        while waiting and waiting[0][0] <= now_s:
            at_s, data = waiting.pop(0)
            arrived += tcp.take(at_s)
            tcp.push(data, at_s)
            count += len(data)
        arrived += tcp.take(now_s)
        assert everything.startswith(arrived)
        assert tcp.in_flight == count - len(arrived)
        seen.append((now_s, count, len(arrived)))
    return seen


def at_times(gaps: list[tuple[float, bytes]]) -> list[tuple[float, bytes]]:
    times, now_s = [], 0.0
    for gap_s, data in gaps:
        now_s += gap_s
        times.append((now_s, data))
    return times


@given(networks(), sendings)
def test_no_byte_is_lost_or_overtaken_or_early(
    network: tuple[NetworkPath, float], gaps: list[tuple[float, bytes]]
) -> None:
    path, shortest_s = network
    sent = at_times(gaps)
    seen = run(path, sent, STEPS_S)
    assert seen[-1][2] == sum(len(data) for _, data in sent)
    for now_s, _, arrived in seen:
        assert arrived <= sum(len(data) for at_s, data in sent if at_s + shortest_s <= now_s + SOON_S)


@given(st.data(), sendings)
def test_how_often_somebody_looks_changes_nothing(data: st.DataObject, gaps: list[tuple[float, bytes]]) -> None:
    path, _ = data.draw(networks())
    again = NetworkPath(path.conditions)
    again.stalls, again.partitions = path.stalls, path.partitions
    sent = at_times(gaps)
    fine = {now_s: arrived for now_s, _, arrived in run(path, sent, STEPS_S)}
    coarse = {now_s: arrived for now_s, _, arrived in run(again, sent, STEPS_S[:: data.draw(st.integers(2, 300))])}
    assert coarse == {now_s: fine[now_s] for now_s in coarse}


@given(st.floats(0.0, 10.0), st.floats(0.0, 1.0))
def test_a_plain_delay_is_exact(sent_s: float, delay_s: float) -> None:
    tcp = stream(Conditions(delay_s))
    tcp.push(b"motion", sent_s)
    if delay_s > 1e-6:
        assert tcp.take(sent_s + delay_s - 1e-6) == b""
    assert tcp.take(sent_s + delay_s) == b"motion"
    assert tcp.carried.longest_s == pytest.approx(delay_s, abs=1e-12)


@pytest.mark.parametrize("apart_s", [0.001, 0.002, 0.012])
def test_a_lost_segment_holds_everything_until_later_ones_have_shown_the_loss(apart_s: float) -> None:
    delay_s = 0.02
    tcp = losing(delay_s, [0.1])
    for n in range(100):
        tcp.push(bytes([n]), apart_s * n)
    shown_s = 2 * delay_s + min(LATER_SEGMENTS * apart_s, max(apart_s, REORDERING * 2 * delay_s))
    again_s = shown_s + delay_s
    assert tcp.take(again_s - 1e-6) == b""
    assert tcp.take(again_s + 1e-9) == bytes(range(math.floor((again_s - delay_s) / apart_s + 1e-6) + 1))
    assert tcp.carried.retransmitted == 1


def test_a_lone_lost_segment_waits_for_a_timeout_that_doubles() -> None:
    tcp = losing(0.01, [0.1], [0.1, 0.1])
    tcp.push(b"x", 0.0)
    again_s = 0.01 + (0.02 + TIMEOUT_MARGIN_S) * (1 + 2 + 4)
    assert tcp.take(again_s - 1e-6) == b""
    assert tcp.take(again_s + 1e-9) == b"x"
    assert tcp.carried.retransmitted == 3


def test_a_later_segment_that_is_lost_too_shows_no_loss() -> None:
    delay_s = 0.01
    tcp = losing(delay_s, [0.1, 0.1])
    for n in range(3):
        tcp.push(bytes([n]), 0.03 * n)
    again_s = 0.06 + 2 * delay_s + delay_s  # the third one shows it
    assert tcp.take(again_s - 1e-6) == b""
    assert tcp.take(again_s + 1e-9) == bytes(range(3))


def test_a_timeout_is_longer_than_a_round_trip() -> None:
    assert Conditions(0.28).retransmission_s == pytest.approx(0.56 + TIMEOUT_MARGIN_S)
    assert Conditions(0.28, 0.1).retransmission_s == pytest.approx(0.76 + TIMEOUT_MARGIN_S)


def test_the_share_of_lost_segments_is_that_of_the_network() -> None:
    tcp = stream(Conditions(0.01, loss=0.1), Random(3))
    for n in range(5000):
        tcp.push(b"x", float(n * 60))
    tcp.take(FAR_S)
    # 5000 segments, each sent again 1/9 times on average: 556 with a standard deviation of 25.
    assert 456 < tcp.carried.retransmitted < 656


def test_in_a_partition_tcp_tries_again_and_again_and_is_through_soon_after_it() -> None:
    tcp = stream(Conditions(0.01))
    tcp.path.partitions.add(1.0, 2.0)
    for n in range(60):
        tcp.push(bytes([n]), 0.9805 + 0.001 * n)
    assert tcp.take(1.0) == bytes(range(10))  # sent before 0.99
    through_s = 1.0 + (0.02 + TIMEOUT_MARGIN_S) * (1 + 2 + 4 + 8)
    assert tcp.take(through_s - 0.002) == b""
    assert tcp.take(through_s + 0.002) == bytes(range(10, 60))


def test_a_stall_ends_in_a_burst_and_nothing_is_sent_again() -> None:
    tcp = stream(Conditions(0.01))
    tcp.path.stalls.add(1.0, 3.0)
    tcp.push(b"before", 0.9)
    tcp.push(b"in", 1.5)
    tcp.push(b"side", 2.5)
    assert tcp.take(3.999) == b"before"
    assert tcp.take(4.0) == b"inside"
    assert tcp.carried.retransmitted == 0


def test_jitter_varies_the_delay_to_both_sides() -> None:
    tcp = stream(Conditions(0.05, 0.02))
    arrivals_s = []
    for n in range(400):
        tcp.push(b"x", 0.1 * n)
        arrivals_s.append(next(t for t in range(0, 100) if tcp.take(0.1 * n + 0.001 * t)))
    assert min(arrivals_s) < 40
    assert max(arrivals_s) > 60
    assert all(30 <= arrival_ms <= 71 for arrival_ms in arrivals_s)


def test_jitter_wanders_so_that_neighbours_stay_together() -> None:
    tcp = stream(Conditions(0.05, 0.02))
    for n in range(100):
        arrivals_s: list[float] = []
        for sent_s in (0.1 * n + 0.001, 0.1 * n + 0.002):
            tcp.push(b"x", sent_s)
        for step in range(1000):
            now_s = 0.1 * n + 0.002 + 0.0001 * step
            arrivals_s += [now_s] * len(tcp.take(now_s))
        assert len(arrivals_s) == 2
        # 1 ms apart when sent; a deviation of 2 x 20 ms takes the 20 ms of JITTER_EVERY_S, so at most 2 ms more.
        assert arrivals_s[1] - arrivals_s[0] < 0.0032


def test_two_streams_overtake_each_other() -> None:
    path = NetworkPath(lambda _: Conditions(0.05, 0.02))
    first_ahead = second_ahead = 0
    one, two = TcpStream(path, Random(1)), TcpStream(path, Random(2))
    for n in range(200):
        for tcp in (one, two):
            tcp.push(b"x", 0.1 * n)
        for t in range(100):
            arrived = [bool(tcp.take(0.1 * n + 0.001 * t)) for tcp in (one, two)]
            first_ahead += arrived == [True, False] and two.in_flight
            second_ahead += arrived == [False, True] and one.in_flight
    assert first_ahead > 20
    assert second_ahead > 20


def test_all_streams_share_the_rate() -> None:
    path = NetworkPath(lambda _: Conditions(0.1, rate_bit_s=8000.0))
    one, two = TcpStream(path, Random(1)), TcpStream(path, Random(2))
    one.push(bytes(1000), 0.0)
    two.push(bytes(500), 0.0)
    assert one.take(1.099) == b""
    assert len(one.take(1.101)) == 1000
    assert two.take(1.599) == b""
    assert len(two.take(1.601)) == 500


def test_a_sender_is_held_back_when_too_much_waits_or_is_on_its_way() -> None:
    slow = stream(Conditions(rate_bit_s=1e6))
    slow.push(bytes(QUEUE_BYTES), 0.0)
    assert not slow.full(0.0)
    slow.push(bytes(SEGMENT_BYTES), 0.0)
    assert slow.full(0.0)
    assert not slow.full(0.1)
    long = stream(Conditions(60.0))
    long.push(bytes(WINDOW_BYTES), 0.0)
    assert long.full(59.0)
    long.take(60.0)
    assert not long.full(60.0)


def test_what_vanishes_never_arrives_and_holds_nobody_back() -> None:
    tcp = stream(Conditions(0.1))
    tcp.push(bytes(WINDOW_BYTES), 0.0)
    tcp.vanish()
    tcp.push(b"more", 0.1)
    tcp.push(b"", 0.2)
    assert tcp.take(FAR_S) == b""
    assert not tcp.ended
    assert not tcp.full(0.3)


def test_one_seed_gives_one_network() -> None:
    def arrivals(seed: int) -> list[bytes]:
        tcp = stream(Conditions(0.03, 0.02, 0.2), Random(seed))
        found = []
        for n in range(2000):
            tcp.push(bytes([n % 256]), 0.002 * n)
            found.append(tcp.take(0.002 * n))
        return found

    assert arrivals(5) == arrivals(5)
    assert arrivals(5) != arrivals(6)
