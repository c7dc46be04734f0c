"""Stability over a delayed link: direct force, wave variables, time-domain passivity and the local model compared.

The study simulates an operator's finger, an exoskeleton, a link and a remote finger on a wall (`plant`). It runs a
matrix of delays, walls, hands, periods and links. It also calculates the analytic limits (`limits`) and runs recorded
round trips and hands.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from studies.compared import Compared
from studies.pieces import HERE, Piece, Work, rows_of
from studies.running import Progress, tables_of
from studies.teleoperation_stability.cases import DEVICE_NS_M, HANDS
from studies.teleoperation_stability.limits import (
    FREE,
    Loop,
    sampled_wall_n_m,
    simulated_n_m,
    simulated_wall_n_m,
    worked_out_n_m,
)
from studies.teleoperation_stability.matrix import FULL, LOCAL, QUICK, matrix_pieces, summary
from studies.teleoperation_stability.measures import FORCE_MOST_N, PRODUCED_J
from studies.teleoperation_stability.recorded import recorded_pieces

AGREE = 0.15
PERIOD_S = 0.001
BORDER_S = ((0.0, 0.010, 0.020, 0.050), (0.100, 0.200), (0.400,))
"""Round trips, s, whose stability limit is searched, in groups that are watched for the same time."""
QUICK_BORDER_S = ((0.020, 0.100),)
PERIODS_S = (0.001, 0.002, 0.005)
tables = tables_of("summary", "borders", "walls", "recorded", "matrix")
COMPARED = (
    *(
        Compared("summary", column, "less", ("link",), {"architecture": LOCAL})
        for column in ("swing", "produce_energy", "push_too_hard")
    ),
    Compared("summary", "most_produced_mj", "less", ("link",), {"architecture": LOCAL}, relative=0.1),
    Compared("summary", "peak_n", "less", ("link",), {"architecture": LOCAL}, relative=0.1),
    Compared(
        "matrix",
        "felt_n_m",
        "same",
        ("hand", "period_ms", "round_trip_ms", "wall_n_m"),
        {"architecture": LOCAL, "link": "steady"},
        relative=0.02,
    ),
    Compared("borders", "simulated_share", "same", ("hand", "round_trip_ms"), absolute=0.05),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Run all parts: the matrix, its summary, stability limits, sampled walls and recorded runs.

    `problems` lists those of the local model and of the limits. Recorded runs need recordings in the folder
    TELETACTION_DATA.
    """
    matrix = QUICK if quick else FULL
    pieces: dict[str, list[Piece]] = {
        "borders": [(_borders, (trips_s, seed)) for trips_s in (QUICK_BORDER_S if quick else BORDER_S)],
        "walls": [(_walls, (period_s,)) for period_s in (PERIODS_S[:1] if quick else PERIODS_S)],
        "recorded": recorded_pieces(quick, seed),
        "matrix": matrix_pieces(matrix, seed),
    }
    found = rows_of(pieces, work, progress)
    data = {"summary": list(summary(found["matrix"])), **found}
    return data | {"problems": list(_problems(data))}


def _borders(trips_s: tuple[float, ...], seed: int) -> Iterator[dict[str, Any]]:
    """Yield the largest stable wall of direct position-force control, calculated and simulated."""
    varied = [(name, Loop(hand, trip_s, PERIOD_S)) for name, hand in HANDS.items() for trip_s in trips_s]
    for (name, loop), found in zip(varied, simulated_n_m([loop for _, loop in varied], seed), strict=True):
        worked_out = worked_out_n_m(loop)
        both = worked_out is not None and found is not None
        yield {
            "hand": name,
            "round_trip_ms": 1e3 * loop.round_trip_s,
            "worked_out_n_m": worked_out,
            "simulated_n_m": found,
            "simulated_share": found / worked_out if both and found and worked_out else None,
        }


def _walls(period_s: float) -> Iterator[dict[str, Any]]:
    """Yield the largest stable virtual wall of the device alone, calculated and simulated."""
    yield {
        "period_ms": 1e3 * period_s,
        "bound_n_m": 2.0 * DEVICE_NS_M / period_s,
        "worked_out_n_m": sampled_wall_n_m(FREE, period_s),
        "simulated_n_m": simulated_wall_n_m(period_s),
    }


def _problems(data: Mapping[str, Any]) -> Iterator[str]:
    for row in data["summary"]:
        if row["architecture"] == LOCAL and (row["swing"] or row["produce_energy"] or row["push_too_hard"]):
            yield f"local model, {row['link']}: {row['swing']} oscillate, {row['produce_energy']} produce energy, " + (
                f"{row['push_too_hard']} push too hard, of {row['runs']} runs"
            )
    for row in data["recorded"]:
        if row["architecture"] == LOCAL and not (
            row["produced_mj"] <= 1e3 * PRODUCED_J and row["peak_n"] <= FORCE_MOST_N
        ):
            yield f"local model, {row['recording']}, {row['hand']}: {row['produced_mj']:.1f} mJ, {row['peak_n']:.1f} N"
    for row in data["borders"]:
        share = row["simulated_share"]
        if share is not None and not abs(share - 1.0) <= AGREE:
            yield f"limit, {row['hand']}, {row['round_trip_ms']:.0f} ms: simulated {share:.2f} of the calculated wall"
