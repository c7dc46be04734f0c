"""Ages on the page are true after the site's clock was put forward by a standstill of its host; so are times of day."""

import math
from datetime import datetime, timedelta
from itertools import count

from operator_site.console.model import Console
from operator_site.console.state.site_now import SILENT_S
from operator_site.console.state.site_time import SiteTime, WallClock
from tests.unit.operator_site.console.fed import S, rendered

BATCH_S = 0.03
LATE_S = 0.01
NOON = datetime(2026, 11, 3, 12, 0, 0)


def heard_of(console: Console, time: SiteTime, here_s: float, ahead_s: float) -> None:
    """The site feeds one message, which is LATE_S on its way."""
    site_s = here_s - LATE_S + ahead_s
    console.take("operator/rendered", round(site_s * S), rendered())
    time.heard(here_s, site_s)


def test_silence_is_seen_after_a_standstill_as_before_it() -> None:
    for ahead_s in (0.0, 0.08, 30.0, 3600.0):
        console, time = Console(), SiteTime()
        for n in range(10):
            heard_of(console, time, 100.0 + n * BATCH_S, 0.0)
        for n in range(10, 20):
            heard_of(console, time, 100.0 + n * BATCH_S, ahead_s)
        last_s = 100.0 + 19 * BATCH_S
        assert 0.0 <= console.site.silent_s(time.now_s(last_s)) <= LATE_S + 1e-6
        silent_s = next(n * 0.01 for n in count() if console.site.silent_s(time.now_s(last_s + n * 0.01)) > SILENT_S)
        assert SILENT_S - LATE_S <= silent_s <= SILENT_S + 0.01


def test_a_site_that_was_started_again_is_on_the_consoles_clock() -> None:
    time = SiteTime()
    time.heard(100.0, 130.0)
    time.heard(101.0, 130.9)
    assert time.now_s(101.0) == 131.0, "a late message is no slower clock"
    time.heard(102.0, 101.99)
    assert time.now_s(102.0) == 102.0


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
