"""The clock anchor of a recording: which pair of readings it keeps, and its conversion."""

from itertools import count

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.recording.clock_anchor import ClockAnchor, clock_id

WHOLE = st.integers(min_value=0, max_value=2**62)


def test_the_pair_with_the_smallest_uncertainty_is_kept() -> None:
    monotonic = iter([0, 900, 1000, 1010, 2000, 2500, 3000, 3800, 4000, 4600])
    wall = count(7_000_000, 1000)
    anchor = ClockAnchor.now(lambda: next(monotonic), lambda: next(wall))
    assert anchor == ClockAnchor(clock_id(), 1005, 7_001_000, 5)


@given(monotonic_ns=WHOLE, wall_ns=WHOLE, later_ns=WHOLE)
def test_a_time_keeps_its_distance_from_the_anchor(monotonic_ns: int, wall_ns: int, later_ns: int) -> None:
    anchor = ClockAnchor("boot", monotonic_ns, wall_ns, 0)
    assert anchor.wall_time_ns(monotonic_ns + later_ns) == wall_ns + later_ns


@given(st.builds(ClockAnchor, st.text(min_size=1), WHOLE, WHOLE, WHOLE))
def test_metadata_give_the_anchor_back(anchor: ClockAnchor) -> None:
    assert ClockAnchor.read(anchor.metadata() | {"version": "0.2.0"}) == anchor


def test_an_older_recording_has_no_anchor() -> None:
    assert ClockAnchor.read({"version": "0.1.0"}) is None


@pytest.mark.parametrize("damage", [{"wall_ns": "soon"}, {"monotonic_ns": ""}])
def test_a_damaged_anchor_is_an_error(damage: dict[str, str]) -> None:
    with pytest.raises(ValueError, match="clock anchor"):
        ClockAnchor.read(ClockAnchor("boot", 1, 2, 3).metadata() | damage)
