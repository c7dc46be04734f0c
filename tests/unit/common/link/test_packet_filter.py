from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.link.packet_filter import FUTURE_TOLERANCE_NS, MOST_AHEAD, PacketFilter

MS = 1_000_000
MAX_AGE = 150 * MS


@dataclass(frozen=True)
class Packet:
    session: int
    sequence: int
    time_ns: int


def accept(
    acceptance: PacketFilter, packet: Packet, now_ns: int, offset_ns: int = 0, uncertainty_ns: int | None = 0
) -> bool:
    return acceptance.accept(packet, 1, now_ns, offset_ns, uncertainty_ns)


arrivals = st.lists(st.tuples(st.integers(0, 3), st.integers(0, 30), st.integers(-400, 50)), max_size=40)


@given(arrivals, st.integers(0, 20))
def test_accepted_packets_are_new_in_order_and_young(arrivals: list[tuple[int, int, int]], uncertainty_ms: int) -> None:
    acceptance = PacketFilter(MAX_AGE)
    now_ns, highest, accepted = 10**12, -1, 0
    for session, sequence, age_ms in arrivals:
        now_ns += 2 * MS
        packet = Packet(session, sequence, now_ns + age_ms * MS)
        if accept(acceptance, packet, now_ns, 0, uncertainty_ms * MS):
            accepted += 1
            assert session == 1
            assert sequence > highest
            assert -age_ms * MS <= MAX_AGE
            assert age_ms * MS <= FUTURE_TOLERANCE_NS + uncertainty_ms * MS
            assert (acceptance.age_ns, acceptance.gap_ns(now_ns + 7)) == (-age_ms * MS, 7)
            highest = sequence
    assert acceptance.received == accepted
    assert acceptance.refused.total() + acceptance.overtaken == len(arrivals) - accepted


@pytest.mark.parametrize(
    ("packet", "uncertainty", "reason"),
    [
        (Packet(2, 5, 0), 0, "session"),
        (Packet(1, 2**62, 0), 0, "sequence"),
        (Packet(1, 5 + MOST_AHEAD, 0), 0, "sequence"),
        (Packet(1, 4 + MOST_AHEAD, 0), 0, ""),
        (Packet(1, 100, -(10**9)), 0, "age"),
        (Packet(1, 5, 0), None, "clock"),
        (Packet(1, 5, -151 * MS), 0, "age"),
        (Packet(1, 5, 6 * MS), 0, "future"),
        (Packet(1, 5, -151 * MS), 2 * MS, "age"),
        (Packet(1, 5, 0), 151 * MS, "clock"),
        (Packet(1, 5, -149 * MS), 150 * MS, ""),
        (Packet(1, 5, 6 * MS), 2 * MS, ""),
        (Packet(1, 5, -MAX_AGE), 0, ""),
        (Packet(1, 5, -MAX_AGE - 1), 0, "age"),
        (Packet(1, 5, FUTURE_TOLERANCE_NS + 7), 7, ""),
        (Packet(1, 5, FUTURE_TOLERANCE_NS + 8), 7, "future"),
    ],
)
def test_each_reason_is_counted_and_a_refused_packet_blocks_nothing(
    packet: Packet, uncertainty: int | None, reason: str
) -> None:
    acceptance = PacketFilter(MAX_AGE)
    assert accept(acceptance, Packet(1, 4, 0), 0)
    assert accept(acceptance, packet, 0, 0, uncertainty) is not bool(reason)
    assert dict(acceptance.refused) == ({reason: 1} if reason else {})
    assert acceptance.latest_refusal == reason
    assert accept(acceptance, Packet(1, 5 if reason else packet.sequence + 1, 0), 0)
    assert acceptance.latest_refusal == ""


@pytest.mark.parametrize("sequence", [1, 3, 4])
def test_a_packet_after_a_newer_one_is_not_accepted_and_is_no_refusal(sequence: int) -> None:
    acceptance = PacketFilter(MAX_AGE)
    assert accept(acceptance, Packet(1, 4, 0), 0)
    assert not accept(acceptance, Packet(1, sequence, -(10**9)), 0)
    assert (acceptance.refused, acceptance.overtaken, acceptance.latest_refusal) == ({}, 1, "overtaken")
    assert accept(acceptance, Packet(1, 5, 0), 0)
    assert (acceptance.latest_refusal, acceptance.lost) == ("", 0)


def test_a_session_with_a_known_first_number_accepts_none_from_before_or_far_beyond() -> None:
    acceptance = PacketFilter(MAX_AGE)
    for first in (10**15, 7):
        acceptance.restart(first)
        for wrong in (0, 1, first - 1, first + MOST_AHEAD, 2**62):
            assert not accept(acceptance, Packet(1, wrong, 0), 0)
            assert acceptance.latest_refusal == "sequence"
        assert accept(acceptance, Packet(1, first + 3, 0), 0)
        assert acceptance.lost == 0, "what was sent before the clocks were compared is not lost"
        assert not accept(acceptance, Packet(1, first + 3 + MOST_AHEAD + 1, 0), 0)
        assert not accept(acceptance, Packet(1, first - 1, 0), 0)
        assert acceptance.latest_refusal == "sequence"
        assert accept(acceptance, Packet(1, first + 3 + MOST_AHEAD, 0), 0)
        acceptance.lost = 0


def test_a_stream_may_begin_with_0_and_is_judged_from_there() -> None:
    acceptance = PacketFilter(MAX_AGE)
    assert accept(acceptance, Packet(1, 0, 0), 0)
    assert not accept(acceptance, Packet(1, 1 + MOST_AHEAD, 0), 0)
    assert accept(acceptance, Packet(1, 3, 0), 0)
    assert acceptance.lost == 2


def test_a_stream_whose_first_number_is_unknown_may_begin_anywhere() -> None:
    acceptance = PacketFilter(MAX_AGE)
    for late in (2 * MOST_AHEAD, 10 * MOST_AHEAD):
        acceptance.restart()
        assert accept(acceptance, Packet(1, late, 0), 0)
        assert not accept(acceptance, Packet(1, late + MOST_AHEAD + 1, 0), 0)


def test_superseded_packets_are_counted_and_a_new_session_starts_over() -> None:
    acceptance = PacketFilter(MAX_AGE)
    assert acceptance.gap_ns(5) is None
    for sequence in (1, 2, 6, 7):
        assert accept(acceptance, Packet(1, sequence, 0), 0)
    assert acceptance.lost == 3
    assert not accept(acceptance, Packet(1, 7, 0), 0)
    acceptance.restart()
    assert acceptance.gap_ns(5) is None
    assert acceptance.latest_refusal == ""
    assert not accept(acceptance, Packet(1, -1, 0), 0)
    assert accept(acceptance, Packet(1, 1, 0), 0)
    assert acceptance.lost == 3, "nothing is lost before the first of a session"


@given(st.integers(-(10**15), 10**15), st.integers(0, 149))
def test_another_hosts_clock_makes_no_difference(offset_ns: int, age_ms: int) -> None:
    acceptance = PacketFilter(MAX_AGE)
    now_ns = 2 * 10**15
    assert accept(acceptance, Packet(1, 1, now_ns - age_ms * MS + offset_ns), now_ns, offset_ns)
    assert acceptance.age_ns == age_ms * MS
