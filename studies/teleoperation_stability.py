"""Stability over a delayed link: direct force, wave variables, time-domain passivity and the local model, side by side.

An operator's finger, an exoskeleton, a link and a remote finger on a wall (studies/stability_plant.py) are simulated
for a matrix of delays, walls, hands, periods and links, with the analytic limits beside (studies/stability_limits.py)
and recorded round trips and hands as further runs.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from studies.registry import Tell
from studies.stability_cases import DEVICE_NS_M, HANDS
from studies.stability_figure import plot
from studies.stability_limits import FREE, Loop, sampled_wall_n_m, simulated_n_m, simulated_wall_n_m, worked_out_n_m
from studies.stability_matrix import FULL, LOCAL, QUICK, matrix_rows, summary
from studies.stability_measures import FORCE_MOST_N, PRODUCED_J
from studies.stability_recorded import recorded_rows

__all__ = ["plot", "run", "tables"]

AGREE = 0.15
PERIOD_S = 0.001
BORDER_S = ((0.0, 0.010, 0.020, 0.050), (0.100, 0.200), (0.400,))
"""Round trips whose border is looked for, in the groups that are watched for equally long."""
QUICK_BORDER_S = ((0.020, 0.100),)
PERIODS_S = (0.001, 0.002, 0.005)


def run(quick: bool, seed: int, tell: Tell) -> dict[str, Any]:
    """The matrix, its summary, borders, sampled walls, recorded runs, and `problems` of local model and borders."""
    tell("borders")
    borders = [row for trips_s in (QUICK_BORDER_S if quick else BORDER_S) for row in _borders(trips_s, seed)]
    walls = list(_walls(PERIODS_S[:1] if quick else PERIODS_S))
    tell("recorded round trips and hands")
    recorded = list(recorded_rows(quick, seed))
    if not recorded:
        tell("no recordings: name their folder in TELETACTION_DATA")
    tell("matrix")
    matrix, rows = (QUICK if quick else FULL), []
    total = 5 * len(matrix.periods_s) * len(matrix.hands)
    total *= len(matrix.links) * len(matrix.round_trips_s) * len(matrix.walls_n_m)
    for row in matrix_rows(matrix, seed):
        rows.append(row)
        if len(rows) % 100 == 0:
            tell(len(rows) / total)
    data = {
        "quick": quick,
        "summary": list(summary(rows, 1e3 * PRODUCED_J, FORCE_MOST_N)),
        "borders": borders,
        "walls": walls,
        "recorded": recorded,
        "matrix": rows,
    }
    return data | {"problems": list(_problems(data))}


def tables(data: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """All rows by what they tell."""
    return {name: data[name] for name in ("summary", "borders", "walls", "recorded", "matrix")}


def _borders(trips_s: tuple[float, ...], seed: int) -> Iterator[dict[str, Any]]:
    """Direct position-force: largest stable wall, worked out and simulated."""
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


def _walls(periods_s: tuple[float, ...]) -> Iterator[dict[str, Any]]:
    """The device alone on its own virtual wall."""
    for period_s in periods_s:
        yield {
            "period_ms": 1e3 * period_s,
            "bound_n_m": 2.0 * DEVICE_NS_M / period_s,
            "worked_out_n_m": sampled_wall_n_m(FREE, period_s),
            "simulated_n_m": simulated_wall_n_m(period_s),
        }


def _problems(data: Mapping[str, Any]) -> Iterator[str]:
    for row in data["summary"]:
        if row["architecture"] == LOCAL and (row["swing"] or row["produce_energy"] or row["push_too_hard"]):
            yield f"local model, {row['link']}: {row['swing']} swing, {row['produce_energy']} produce, " + (
                f"{row['push_too_hard']} push too hard, of {row['runs']}"
            )
    for row in data["recorded"]:
        if row["architecture"] == LOCAL and not (
            row["produced_mj"] <= 1e3 * PRODUCED_J and row["peak_n"] <= FORCE_MOST_N
        ):
            yield f"local model, {row['recording']}, {row['hand']}: {row['produced_mj']:.1f} mJ, {row['peak_n']:.1f} N"
    for row in data["borders"]:
        share = row["simulated_share"]
        if share is not None and not abs(share - 1.0) <= AGREE:
            yield f"border, {row['hand']}, {row['round_trip_ms']:.0f} ms: simulated {share:.2f} of what is worked out"
