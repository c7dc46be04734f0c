"""The highest and lowest of the last set-points, against looking through all of them."""

import math

from hypothesis import example, given
from hypothesis import strategies as st

from remote_site.safety.sliding_extrema import MEMORY_S, SlidingExtrema


@example([(0.0, 1.0), (0.0, -1.0), (MEMORY_S, 0.0)])
@example([(0.2347243933826205, 0.0), (MEMORY_S, 1.0)])  # its age is MEMORY_S only where the difference is rounded
@given(st.lists(st.tuples(st.floats(0.0, 0.3), st.floats(-1.0, 1.0)), min_size=1, max_size=60))
def test_the_extremes_are_those_of_recent_set_points(set_points: list[tuple[float, float]]) -> None:
    recent, t_s, values = SlidingExtrema(), 0.0, []
    assert (recent.lowest, recent.highest) == (math.inf, -math.inf)
    for after_s, value in set_points:
        t_s += after_s
        recent.add(t_s, value)
        values.append((t_s, value))
        fresh = [value for then_s, value in values if then_s >= t_s - MEMORY_S]
        assert (recent.lowest, recent.highest) == (min(fresh), max(fresh))
