"""Runs the matrix of the stability study: every architecture, hand, wall, delay, kind of link and period."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from studies.counting import grouped
from studies.pieces import Piece
from studies.teleoperation_stability.blended_contact import BlendedContact
from studies.teleoperation_stability.cases import HANDS, Floats, cases
from studies.teleoperation_stability.direct import DirectForce
from studies.teleoperation_stability.local_model import LocalModel, passive
from studies.teleoperation_stability.measures import FORCE_MOST_N, PRODUCED_J, SECONDS, START_M, PressTwice, measure
from studies.teleoperation_stability.network import way
from studies.teleoperation_stability.passivity import PassivityControl
from studies.teleoperation_stability.plant import Architecture, simulate
from studies.teleoperation_stability.waves import WaveVariables

DIRECT, WAVES, PASSIVITY = "direct position-force", "wave variables", "time-domain passivity"
LOCAL, BLENDED = "local model", "local model, blended"
ARCHITECTURES: dict[str, Callable[[Floats, float], Architecture]] = {
    DIRECT: lambda start_m, _: DirectForce(start_m),
    WAVES: WaveVariables,
    PASSIVITY: PassivityControl,
    BLENDED: lambda start_m, period_s: LocalModel(start_m, period_s, BlendedContact),
    LOCAL: lambda start_m, period_s: LocalModel(start_m, period_s, passive(period_s)),
}


@dataclass(frozen=True, slots=True)
class Link:
    """Disturbances of a run.

    Attributes:
        jitter_s: mean additional delay of a packet.
        loss: share of lost packets, 0..1.
        breath_m: peak-to-peak motion of the wall.
    """

    jitter_s: float = 0.0
    loss: float = 0.0
    breath_m: float = 0.0


LINKS = {
    "steady": Link(),
    "jitter 10 ms": Link(jitter_s=0.010),
    "loss 5 %": Link(loss=0.05),
    "loss 20 %, jitter 10 ms": Link(jitter_s=0.010, loss=0.20),
    "breathing wall": Link(breath_m=0.002),
}


@dataclass(frozen=True, slots=True)
class Matrix:
    """Varied parameters: periods, s, round trips, s, walls, N/m, and links and hands by name."""

    periods_s: tuple[float, ...]
    round_trips_s: tuple[float, ...]
    walls_n_m: tuple[float, ...]
    links: tuple[str, ...]
    hands: tuple[str, ...] = tuple(HANDS)


FULL = Matrix(
    (0.001, 0.002, 0.005),
    (0.0, 0.010, 0.020, 0.050, 0.100, 0.200, 0.400),
    (50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0),
    tuple(LINKS),
)
QUICK = Matrix(
    (0.002,),
    (0.0, 0.020, 0.100, 0.400),
    (100.0, 500.0, 5000.0),
    ("steady", "loss 20 %, jitter 10 ms", "breathing wall"),
    ("light", "arm"),
)


def matrix_pieces(matrix: Matrix, seed: int) -> list[Piece]:
    """Return a piece for each period, hand and architecture."""
    places = product(range(len(matrix.periods_s)), range(len(matrix.hands)), ARCHITECTURES)
    return [(matrix_rows, (matrix, number, place, name, seed)) for number, place, name in places]


def matrix_rows(matrix: Matrix, number: int, place: int, name: str, seed: int) -> Iterator[dict[str, Any]]:
    """Yield a row for each run of a period and a hand, by their indices in the matrix, and an architecture, by name.

    All architectures get the same links for a hand and period.
    """
    period_s, hand = matrix.periods_s[number], matrix.hands[place]
    varied = list(product(matrix.links, matrix.round_trips_s, matrix.walls_n_m))
    links = [LINKS[link] for link, _, _ in varied]
    runs = cases((HANDS[hand], wall, link.breath_m) for (_, _, wall), link in zip(varied, links, strict=True))
    rng = np.random.default_rng([seed, number, place])
    jitter_s, loss = np.array([link.jitter_s for link in links]), np.array([link.loss for link in links])
    round_trip_s = np.array([each for _, each, _ in varied])
    ticks = round(SECONDS / period_s)
    forward, backward = (way(ticks, period_s, round_trip_s, jitter_s, loss, rng) for _ in range(2))
    sites = ARCHITECTURES[name](np.full(len(runs), START_M), period_s)
    noise = np.random.default_rng([seed, number, place, 1])
    course = simulate(runs, sites, PressTwice(runs), forward, backward, period_s=period_s, rng=noise)
    for (link_name, trip_s, wall), measured in zip(varied, measure(course), strict=True):
        yield {
            "architecture": name,
            "hand": hand,
            "period_ms": 1e3 * period_s,
            "link": link_name,
            "round_trip_ms": 1e3 * trip_s,
            "wall_n_m": wall,
            **measured,
        }


def summary(rows: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield per architecture and link how many runs oscillate, produce energy or push too hard, and the worst."""
    for (name, link), mine in grouped(rows, "architecture", "link").items():
        yield {
            "architecture": name,
            "link": link,
            "runs": len(mine),
            "swing": sum(not row["stable"] for row in mine),
            "produce_energy": sum(row["produced_mj"] > 1e3 * PRODUCED_J for row in mine),
            "push_too_hard": sum(row["peak_n"] > FORCE_MOST_N for row in mine),
            "most_produced_mj": max(row["produced_mj"] for row in mine),
            "largest_swing_mm": max(row["swing_mm"] for row in mine),
            "peak_n": max(row["peak_n"] for row in mine),
            "remote_peak_n": max(row["remote_peak_n"] for row in mine),
        }
