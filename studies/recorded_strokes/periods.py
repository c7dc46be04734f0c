"""Counts right and missing periods, and periods within their stated deviation, of made-up and of changed strokes."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.groove_period import Period
from remote_site.texture.recorded.spatial_period import spatial_period
from studies.recorded_strokes.made_strokes import draw, make

Array = NDArray[np.float64]
Row = dict[str, Any]
Answer = tuple[float, Period | None]
"""True period, mm, and the estimate."""

SIGNALS = ("all taxels", "mean", "one taxel")
"""Signals from which a period is estimated; the mean is judged beside all taxels, as `--signal mean` does."""
WITHIN = 0.01
"""Relative error of a good period."""
WRONG = 0.10
"""Relative error of a period that belongs to another line."""
SDS_95 = 1.96
"""Half width of the 95 % interval of a normal value, standard deviations."""


class Board(NamedTuple):
    """A recorded stroke: path, m; signals, samples x taxels; time, s; true period, mm."""

    path_m: Array
    signals: Array
    time_s: Array
    true_mm: float


Change = Callable[[Board, np.random.Generator], Iterable[Board]]
"""Changed strokes of a recorded one."""


def counted(answers: Sequence[Answer]) -> Row:
    """Count the answers; `inside_95` counts wrong periods as outside their interval."""
    found = [(true_mm, 1e3 * one.period_m, 1e3 * one.period_sd_m) for true_mm, one in answers if one is not None]
    errors = [abs(period_mm / true_mm - 1.0) for true_mm, period_mm, _ in found]
    inside = sum(abs(period_mm - true_mm) < SDS_95 * sd_mm for true_mm, period_mm, sd_mm in found)
    return {
        "strokes": len(answers),
        "none": len(answers) - len(found),
        "wrong": sum(error > WRONG for error in errors),
        "within_1_percent": sum(error < WITHIN for error in errors),
        "answers": len(found),
        "inside_95": inside,
        "inside_95_share": inside / len(found) if found else None,
    }


def estimated(path_m: Array, readings: Array, signals: str, chance: np.random.Generator) -> Period | None:
    """Estimate a period from one of SIGNALS."""
    whole = None
    if signals == "mean":
        readings, whole = readings.mean(axis=1, keepdims=True), readings
    elif signals == "one taxel":
        readings = readings[:, [int(chance.integers(readings.shape[1]))]]
    found = spatial_period(path_m, readings, whole)
    return None if found is None else found[0]


def made_periods(speed_mm_s: float, strokes: int, seed: int) -> list[Row]:
    """Count the periods of made-up strokes at one speed, apart for steady ones and those that stick and slip."""
    answers: dict[tuple[str, str], list[Answer]] = {}
    for number in range(strokes):
        chance = np.random.default_rng([seed, round(speed_mm_s), number])
        conditions = draw(chance, speed_mm_s)
        time_s, readings = make(conditions, chance)
        motion = "stick and slip" if conditions.shake > 0.0 else "steady"
        for signals in SIGNALS:
            found = estimated(1e-3 * speed_mm_s * time_s, readings, signals, chance)
            answers.setdefault((signals, motion), []).append((conditions.period_mm, found))
    return [
        {"speed_mm_s": speed_mm_s, "signals": signals, "motion": motion, **counted(answers[signals, motion])}
        for signals, motion in sorted(answers)
    ]


def pooled(rows: Sequence[Row]) -> list[Row]:
    """Add the counts of all speeds, and of both motions."""
    sums = ("strokes", "none", "wrong", "within_1_percent", "answers", "inside_95")
    found = []
    for signals in SIGNALS:
        for motion in ("steady", "stick and slip", "both"):
            part = [row for row in rows if row["signals"] == signals and motion in (row["motion"], "both")]
            row: Row = {"signals": signals, "motion": motion, **{name: sum(one[name] for one in part) for name in sums}}
            found.append(row | {"inside_95_share": row["inside_95"] / row["answers"] if row["answers"] else None})
    return found


def changed_boards(boards: Sequence[Board], seed: int) -> list[Row]:
    """Count the periods of recorded strokes after each of CHANGES."""
    rows = []
    for number, (name, change) in enumerate(CHANGES.items()):
        for signals in SIGNALS[:2]:
            chance = np.random.default_rng([seed, number])
            answers = [
                (one.true_mm, estimated(one.path_m, one.signals, signals, chance))
                for board in boards
                for one in change(board, chance)
            ]
            rows.append({"change": name, "signals": signals, **counted(answers)})
    return rows


def _part(board: Board, samples: Any) -> Board:
    return Board(board.path_m[samples], board.signals[samples], board.time_s[samples], board.true_mm)


def _shaken(board: Board, chance: np.random.Generator, share: float) -> Iterator[Board]:
    """Add an oscillation of the whole sensor as in the recorded fabrics: 2.1 to 2.55 Hz, wandering by 0.04 Hz."""
    for _ in range(4):
        wander_hz = np.interp(board.time_s, np.linspace(0.0, board.time_s[-1], 8), 0.04 * chance.normal(size=8))
        steps_s = np.diff(board.time_s, prepend=board.time_s[0])
        turns = chance.uniform() + np.cumsum((chance.uniform(2.1, 2.55) + wander_hz) * steps_s)
        motion = np.sin(2.0 * np.pi * turns) + 0.3 * np.sin(4.0 * np.pi * turns)
        gains = 1.0 + 0.2 * chance.normal(size=board.signals.shape[1])
        yield board._replace(signals=board.signals * (1.0 + share * motion[:, None] * gains))


def _four_taxels(board: Board, chance: np.random.Generator) -> Iterator[Board]:
    for _ in range(4):
        yield board._replace(signals=board.signals[:, chance.permutation(board.signals.shape[1])[:4]])


CHANGES: Mapping[str, Change] = {
    "as recorded": lambda board, _: [board],
    "shaken by 1 % of the load": partial(_shaken, share=0.01),
    "shaken by 2 % of the load": partial(_shaken, share=0.02),
    "shaken by 4 % of the load": partial(_shaken, share=0.04),
    "halves": lambda board, _: [_part(board, half) for half in np.array_split(np.arange(len(board.path_m)), 2)],
    "every second sample": lambda board, _: [_part(board, slice(first, None, 2)) for first in range(2)],
    "noise of 5 counts": lambda board, chance: [
        board._replace(signals=board.signals + 5.0 * chance.normal(size=board.signals.shape))
    ],
    "four taxels": _four_taxels,
}
"""Changes of the recorded strokes."""
