"""Second connections begin on a long way that loses packets, and end for good where the way has no room for them."""

from random import Random

import pytest

from operator_site.session.second_connections import (
    FAR_NS,
    LATE_BEATS,
    LATE_WITHIN_NS,
    SecondConnections,
)

MS = 1_000_000
BEAT_MS = 50


class Way:
    """Heartbeats on a way; the shortest round trip is that of the last 64, as the clock comparison has it."""

    def __init__(self, round_trip_ms: float) -> None:
        self.second = SecondConnections()
        self.round_trip_ms = round_trip_ms
        self.now_ms = 10**9
        self._last: list[float] = []

    def beat(self, late_ms: float = 0.0) -> bool:
        self.now_ms += BEAT_MS
        round_trip_ms = self.round_trip_ms + late_ms
        self._last = [*self._last[-63:], round_trip_ms]
        self.second.heard(self.now_ms * MS, round(round_trip_ms * MS), round(min(self._last) * MS))
        return self.second.wanted

    def run(self, seconds: float, loss: float = 0.0, seed: int = 0) -> float:
        """Let time pass until second connections are wanted; return how long it took, s, at most `seconds`."""
        chance = Random(seed)
        for number in range(round(seconds * 1e3 / BEAT_MS)):
            lost = any(chance.random() < loss for _ in "to and fro")
            if self.beat(1.25 * self.round_trip_ms * lost):
                return number * BEAT_MS * 1e-3
        return seconds


@pytest.mark.parametrize("round_trip_ms", [0.5, 1e-6 * FAR_NS])
def test_a_near_site_gets_none_whatever_is_lost(round_trip_ms: float) -> None:
    assert Way(round_trip_ms).run(60.0, loss=0.1) == 60.0


@pytest.mark.parametrize("round_trip_ms", [25.0, 100.0, 300.0])
def test_a_far_site_gets_them_soon_where_packets_are_lost_and_never_elsewhere(round_trip_ms: float) -> None:
    assert Way(round_trip_ms).run(600.0) == 600.0
    waits_s = [Way(round_trip_ms).run(60.0, loss=0.01, seed=seed) for seed in range(50)]
    assert sum(waits_s) / len(waits_s) < 10.0
    assert max(waits_s) < 30.0


def test_single_late_heartbeats_long_apart_are_no_loss() -> None:
    way = Way(100.0)
    for _ in range(10):
        for number in range(LATE_WITHIN_NS // ((LATE_BEATS - 1) * BEAT_MS * MS) + 1):
            assert not way.beat(200.0 * (number == 0))


def test_they_end_for_good_where_the_way_becomes_slow_with_them() -> None:
    way = Way(60.0)
    way.run(60.0, loss=0.05)
    assert way.second.wanted
    way.round_trip_ms = 400.0
    waited_ms = 0
    while way.beat():
        waited_ms += BEAT_MS
        assert waited_ms < 2_000
    assert way.second.too_thin
    way.round_trip_ms = 60.0
    assert way.run(300.0, loss=0.05) == 300.0


def test_they_stay_where_the_way_remains_as_it_is() -> None:
    way = Way(60.0)
    way.run(60.0, loss=0.05)
    chance = Random(1)
    assert all(way.beat(80.0 * (chance.random() < 0.1)) for _ in range(20 * 600))


def test_they_stay_where_some_heartbeats_are_far_later_than_before() -> None:
    way = Way(60.0)
    way.run(60.0, loss=0.05)
    assert all(way.beat(400.0 * (number % 10 != 9)) for number in range(1000))


@pytest.mark.parametrize(("slower_ms", "stay"), [(75.0, True), (85.0, False)])
def test_they_end_where_every_round_trip_is_twice_as_long_and_20_ms_more(slower_ms: float, stay: bool) -> None:
    way = Way(60.0)
    way.run(60.0, loss=0.05)
    way.round_trip_ms += slower_ms
    assert all(way.beat() for _ in range(100)) is stay
