"""Places of the server's connections: there is always one for a newcomer, unless pages have all of them."""

import resource
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.web.connections import (
    IDLE_S,
    MOST_CONNECTIONS,
    Connections,
    Stage,
    most_connections,
    raise_descriptor_limit,
)


@dataclass(eq=False)
class Line:
    """A connection of a test."""

    is_open: bool = True
    unsent_bytes: int = 0

    def drop(self) -> None:
        """Nothing is open."""


def filled(*stages: Stage) -> tuple[Connections, list[Line]]:
    """As many connections as there may be, in these stages; each arrived a second after the one before."""
    connections = Connections(len(stages))
    lines = [Line() for _ in stages]
    for at_s, (line, stage) in enumerate(zip(lines, stages, strict=True)):
        assert connections.arrived(line, float(at_s)) is None
        connections.reached(line, stage, float(at_s))
    return connections, lines


@pytest.mark.parametrize(
    ("stages", "dropped"),
    [
        ((Stage.IDLE, Stage.ARRIVING, Stage.ARRIVING, Stage.BUSY), 1),
        ((Stage.PAGE, Stage.BUSY, Stage.IDLE, Stage.IDLE), 2),
        ((Stage.PAGE, Stage.PAGE, Stage.BUSY, Stage.BUSY), 2),
        ((Stage.PAGE, Stage.PAGE), -1),
    ],
)
def test_the_oldest_of_the_lowest_stage_is_dropped_for_a_new_connection_which_is_refused_where_all_are_pages(
    stages: tuple[Stage, ...], dropped: int
) -> None:
    connections, lines = filled(*stages)
    lines.append(Line())
    assert connections.arrived(lines[-1], 9.0) is lines[dropped]
    assert len(connections) == len(stages)
    assert connections.dropped == 1


def test_a_connection_that_closed_leaves_its_place() -> None:
    connections, lines = filled(Stage.PAGE, Stage.ARRIVING)
    lines[1].is_open = False
    assert connections.arrived(Line(), 9.0) is None
    assert connections.dropped == 0


def test_only_a_connection_whose_client_is_waited_for_is_overdue() -> None:
    connections, lines = filled(Stage.ARRIVING, Stage.IDLE, Stage.BUSY, Stage.PAGE)
    assert connections.overdue(IDLE_S) == []
    assert connections.overdue(1.0 + IDLE_S) == [lines[0]]
    assert connections.overdue(100.0) == [lines[1]]
    assert len(connections) == 2


def test_a_dropped_connection_gets_no_place_by_what_it_still_does() -> None:
    connections, lines = filled(Stage.ARRIVING)
    connections.arrived(Line(), 1.0)
    connections.reached(lines[0], Stage.PAGE, 1.0)
    assert len(connections) == 1


@given(st.lists(st.tuples(st.sampled_from(["arrive", *Stage]), st.integers(0, 9), st.floats(0.0, 3.0)), max_size=60))
def test_there_are_never_more_and_no_page_is_ever_dropped(course: list[tuple[str | Stage, int, float]]) -> None:
    connections = Connections(4)
    lines, pages, now_s = [Line()], set[Line](), 0.0
    for what, number, later_s in course:
        now_s += later_s
        line = lines[number % len(lines)]
        if isinstance(what, Stage):
            connections.reached(line, what, now_s)
            (pages.add if what is Stage.PAGE else pages.discard)(line)
            continue
        new = Line()
        dropped = connections.arrived(new, now_s)
        assert dropped is None or dropped is new or dropped not in pages
        lines = [line for line in [*lines, new] if line is not dropped]
        assert len(connections) <= connections.most
        assert not pages & set(connections.overdue(now_s))


def test_connections_leave_descriptors_for_everything_else() -> None:
    assert most_connections(1024) == 256
    assert most_connections(256) == 64
    assert most_connections(1) == 1
    assert most_connections(1 << 20) == MOST_CONNECTIONS


@pytest.mark.parametrize(
    ("soft", "hard", "limit"),
    [(256, 4096, 1024), (256, 512, 512), (256, resource.RLIM_INFINITY, 1024), (20_000, 20_000, 20_000)],
)
def test_the_limit_is_raised_as_far_as_allowed(
    monkeypatch: pytest.MonkeyPatch, soft: int, hard: int, limit: int
) -> None:
    asked: list[tuple[int, int]] = []
    monkeypatch.setattr(resource, "getrlimit", lambda which: (soft, hard))
    monkeypatch.setattr(resource, "setrlimit", lambda which, limits: asked.append(limits))
    assert raise_descriptor_limit() == limit
    assert asked == ([] if soft == limit else [(limit, hard)])
