"""The study of what consoles cost: how its turns are ordered and compared. `make results` runs the study."""

from itertools import islice

from benchmarks.consoles.run import WAYS, more_than, orders


def test_excess_is_counted_turn_by_turn() -> None:
    without = [{"off_us": 100.0}, {"off_us": 300.0}, {"off_us": 200.0}]
    assert more_than([{"off_us": 130.0}, {"off_us": 270.0}, {"off_us": 203.0}], without) == {
        "off_us": {"median": 3.0, "least": -30.0, "most": 30.0, "turns": 2.0}
    }


def test_each_way_comes_in_each_place_equally_often() -> None:
    taken = [*islice(orders(WAYS), 2 * len(WAYS))]
    for place in range(len(WAYS)):
        assert sorted(order[place] for order in taken) == sorted(2 * WAYS)
    assert all(sorted(order) == sorted(WAYS) for order in taken)
