"""A past time of day does not change with jitter, and follows a step of the clock."""

import math
from datetime import datetime, timedelta

from operator_site.console.state.wall_clock import WallClock

NOON = datetime(2026, 11, 3, 12, 0, 0)


def test_a_past_time_keeps_its_time_of_day_through_jitter() -> None:
    wall = WallClock()
    assert wall.at(100.0) == "--"
    wall.take(math.nan, NOON)
    wall.take(100.0, NOON)
    for late_s in (-0.4, 0.0, 0.4):
        wall.take(160.0, NOON + timedelta(seconds=60.0 + late_s))
        assert wall.at(100.0) == "12:00:00"


def test_a_step_of_the_time_of_day_is_followed() -> None:
    wall = WallClock()
    wall.take(100.0, NOON)
    wall.take(101.0, NOON + timedelta(hours=1, seconds=1))
    assert wall.at(100.0) == "13:00:00"
