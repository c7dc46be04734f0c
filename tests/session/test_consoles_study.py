"""The study of what consoles cost, briefly: it runs, five pages are shown all, and cost less than the loop."""

from itertools import islice
from pathlib import Path

import pytest

from studies.consoles import (
    NONE,
    NONE_ORDINARY,
    ORDINARY_WAYS,
    PAGES,
    SEEN,
    WAYS,
    measure,
    more_than,
    orders,
    plot,
    tables,
)


@pytest.mark.session
def test_five_pages_are_shown_everything_and_cost_less_than_the_loop(tmp_path: Path) -> None:
    data = measure(turn_s=3.0, turns=1, watched_s=15.0, seed=0, tell=lambda _: None)
    taken = list(data["ways"])
    assert taken in ([*WAYS, *ORDINARY_WAYS], [*WAYS])  # real-time priority is a right that not everybody has
    ordinary = [row["real_time_share"] for way, row in data["ways"].items() if way in ORDINARY_WAYS]
    assert not any(ordinary)
    assert list(data["more_than_without"]) == [way for way in taken if way not in (NONE, NONE_ORDINARY)]
    assert all(row["ticks"] > 0 for row in data["ways"].values())
    assert data["ways"][NONE]["console_core"] == 0.0
    assert data["core_per_page_with_its_share"] < data["ways"][SEEN]["virtual_core"]
    assert len(data["page"]["pictures_per_s"]) == PAGES
    assert min(data["page"]["pictures_per_s"]) > 15.0
    assert data["memory"]["open_files"][0] > 0
    assert [row["way"] for row in tables(data)["ways"]] == taken
    plot(data, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 10_000


def test_what_is_more_is_told_turn_by_turn() -> None:
    without = [{"off_us": 100.0}, {"off_us": 300.0}, {"off_us": 200.0}]
    assert more_than([{"off_us": 130.0}, {"off_us": 270.0}, {"off_us": 203.0}], without) == {
        "off_us": {"median": 3.0, "least": -30.0, "most": 30.0, "turns": 2.0}
    }


def test_each_way_comes_in_each_place_equally_often() -> None:
    taken = [*islice(orders(WAYS), 2 * len(WAYS))]
    for place in range(len(WAYS)):
        assert sorted(order[place] for order in taken) == sorted(2 * WAYS)
    assert all(sorted(order) == sorted(WAYS) for order in taken)
