"""A growing map is searched for lumps every few seconds, outside of the console's loop."""

import math
from concurrent.futures import Executor, Future
from typing import Any

import pytest

from operator_site.console.background_search import SEARCH_S, BackgroundSearch
from operator_site.console.map.finger_samples import Sample
from operator_site.console.map.lump_areas import NOTHING, search_lumps
from operator_site.console.map.tactile_map import TactileMap


class Later(Executor):
    """Runs what was submitted when the test says so."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Future[Any], Any, tuple[Any, ...]]] = []

    def submit(self, work: Any, /, *arguments: Any, **_: Any) -> Future[Any]:
        self.waiting.append((Future(), work, arguments))
        return self.waiting[-1][0]

    def run(self) -> None:
        for future, work, arguments in self.waiting:
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(work(*arguments))
            except ValueError as error:
                future.set_exception(error)
        self.waiting.clear()


def step(search: BackgroundSearch[Any, Any], now_s: float, surface: TactileMap, number: int) -> None:
    search.step(now_s, number, surface.revision, surface.stiffness.rows)


def press(surface: TactileMap, number: int, x_mm: float, y_mm: float) -> None:
    lift = math.log(2.0) * math.exp(-((math.dist((x_mm, y_mm), (20.0, 28.0)) / 6.0) ** 2))
    place_m = 1e-3 * x_mm, 1e-3 * y_mm
    surface.take(Sample("stiffness", (1, number, 0), number, 1, *place_m, 0.0, math.log(600.0) + lift, 0.02**2))


def pressed() -> TactileMap:
    surface = TactileMap()
    for number, (x, y) in enumerate((x, y) for x in range(0, 60, 4) for y in range(0, 60, 4)):
        press(surface, number, x, y)
    return surface


@pytest.mark.long
def test_a_changed_map_is_searched_at_intervals_and_the_result_shown_when_it_is_there() -> None:
    later, surface = Later(), pressed()
    search = BackgroundSearch("lumps", search_lumps, NOTHING, later)
    step(search, 0.0, surface, 0)
    step(search, 1.0, surface, 0)
    assert (len(later.waiting), search.found) == (1, NOTHING)
    later.run()
    step(search, 2.0, surface, 0)
    (lump,) = search.found.lumps
    assert (lump["x_mm"], lump["y_mm"]) == pytest.approx((20.0, 28.0), abs=1.5)
    assert search.found.next_mm is not None
    assert all(0.0 <= along_mm <= 56.0 for along_mm in search.found.next_mm)
    step(search, SEARCH_S + 3.0, surface, 0)
    assert later.waiting == [], "nothing has changed"
    press(surface, 1000, 70.0, 70.0)
    step(search, SEARCH_S + 4.0, surface, 0)
    assert len(later.waiting) == 1


@pytest.mark.long
def test_another_map_has_no_lumps_of_the_one_before() -> None:
    later, surface = Later(), pressed()
    search = BackgroundSearch("lumps", search_lumps, NOTHING, later)
    step(search, 0.0, surface, 0)
    later.run()
    step(search, 1.0, surface, 0)
    assert search.found.lumps
    step(search, 2.0, TactileMap(), 1)
    assert search.found == NOTHING


def test_a_result_of_the_map_before_is_not_taken() -> None:
    later = Later()
    search = BackgroundSearch("lumps", search_lumps, NOTHING, later)
    step(search, 0.0, pressed(), 0)
    step(search, 1.0, TactileMap(), 1)
    later.run()
    step(search, 2.0, TactileMap(), 1)
    assert search.found == NOTHING


@pytest.mark.long
def test_a_map_after_another_one_is_searched_at_once() -> None:
    later = Later()
    search = BackgroundSearch("lumps", search_lumps, NOTHING, later)
    step(search, 0.0, TactileMap(), 0)
    step(search, 1.0, pressed(), 1)
    later.run()
    step(search, 1.1, pressed(), 1)
    assert search.found.lumps


def test_a_map_with_few_places_has_no_lumps() -> None:
    later, surface = Later(), TactileMap()
    press(surface, 0, 0.0, 0.0)
    search = BackgroundSearch("lumps", search_lumps, NOTHING, later)
    for now_s in (0.0, SEARCH_S, 2.0 * SEARCH_S):
        step(search, now_s, surface, 0)
        later.run()
    assert search.found == NOTHING
