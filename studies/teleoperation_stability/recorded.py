"""Runs recorded round trips and recorded hands, and measures energy and peak force of each architecture.

Each way takes half of a recorded round trip, around the recording's worst moment. A round trip holds until the next
measurement. A real session would enter its safe state during the longest of them; here nothing stops. A recorded leader
gives the intended path of the hand, at the end of a lever of 30 mm. Its wall begins at the median of its path.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from studies.pieces import Piece
from studies.running import data_files, recorded_columns
from studies.teleoperation_stability.cases import HANDS, Floats, cases
from studies.teleoperation_stability.matrix import ARCHITECTURES
from studies.teleoperation_stability.measures import SECONDS, START_M, PressTwice, produced_j
from studies.teleoperation_stability.network import newest, way
from studies.teleoperation_stability.plant import Course, simulate

PERIOD_S = 0.001
WALLS_N_M = (200.0, 1000.0, 5000.0)
LEVER_M = 0.030
TOUCHED_N_M = {"foam": 300.0, "spring": 1000.0, "rigid": 5000.0, "free": 0.0}
ROUND_TRIPS_S = (0.020, 0.100, 0.400)
_WINDOW_S = 2.0


def recorded_pieces(quick: bool, seed: int) -> list[Piece]:
    """Return pieces that make a row for each architecture, recording, hand, and wall or delay.

    The list is empty without recordings. `quick` uses one recorded link only.
    """
    links, motions = data_files("network_rtt"), data_files("bilateral_1dof")
    if quick:
        links, motions = links[3:4], []
    trips_s = {file.stem: round_trip_s(file, round(SECONDS / PERIOD_S)) for file in links}
    touched = {file.stem: (_leader_m(file), _wall_n_m(file)) for file in motions}
    pieces: list[Piece] = [(_over_links, (name, trips_s, seed)) for name in ARCHITECTURES if links]
    return pieces + [(_by_hands, (name, touched, seed)) for name in ARCHITECTURES if motions]


def round_trip_s(file: Path, ticks: int) -> Floats:
    """Return the round trip of a packet sent at each tick around the worst moment of a recording, s."""
    sent_s, rtt_ms = recorded_columns(file, "send_time_s", "rtt_ms")
    worst_s = sent_s[int(np.argmax(rtt_ms))]
    begins_s = max(sent_s[0], min(worst_s - _WINDOW_S, sent_s[-1] - ticks * PERIOD_S))
    last = np.searchsorted(sent_s, begins_s + PERIOD_S * np.arange(ticks), side="right") - 1
    return np.asarray(1e-3 * rtt_ms[np.maximum(0, last)])


def _over_links(name: str, trips_s: Mapping[str, Floats], seed: int) -> Iterator[dict[str, Any]]:
    """Run one architecture over recorded round trips, s at each tick, by recording."""
    varied = [(recording, hand, wall) for recording in trips_s for hand in HANDS for wall in WALLS_N_M]
    half_s = 0.5 * np.stack([trips_s[recording] for recording, _, _ in varied], axis=1)
    one_way = newest(half_s, np.zeros(half_s.shape, bool), PERIOD_S)
    runs = cases((HANDS[hand], wall, 0.0) for _, hand, wall in varied)
    sites, rng = ARCHITECTURES[name](np.full(len(runs), START_M), PERIOD_S), np.random.default_rng(seed)
    course = simulate(runs, sites, PressTwice(runs), one_way, one_way, period_s=PERIOD_S, rng=rng)
    for (recording, hand, wall), worth in zip(varied, _judged(course), strict=True):
        longest_ms = 1e3 * float(trips_s[recording].max())
        yield _row(name, "round trips", recording, hand, longest_ms, wall) | worth


def _by_hands(name: str, touched: Mapping[str, tuple[Floats, float]], seed: int) -> Iterator[dict[str, Any]]:
    """Run one architecture with recorded hands, depth in m at each tick and wall in N/m, by recording."""
    ticks = min(len(path_m) for path_m, _ in touched.values())
    varied = [(recording, hand, trip_s) for recording in touched for hand in HANDS for trip_s in ROUND_TRIPS_S]
    walls = [touched[recording][1] for recording, _, _ in varied]
    meant = np.stack([touched[recording][0][:ticks] for recording, _, _ in varied], axis=1)
    pace = np.gradient(meant, PERIOD_S, axis=0)
    runs = cases((HANDS[hand], wall, 0.0) for (_, hand, _), wall in zip(varied, walls, strict=True))
    rng = np.random.default_rng(seed)
    trips_s, none = np.array([trip_s for _, _, trip_s in varied]), np.zeros(len(varied))
    forward, backward = (way(ticks, PERIOD_S, trips_s, none + 0.005, none + 0.01, rng) for _ in range(2))

    def path(t_s: float) -> tuple[Floats, Floats]:
        tick = min(ticks - 1, round(t_s / PERIOD_S))
        return meant[tick], pace[tick]

    sites = ARCHITECTURES[name](meant[0].copy(), PERIOD_S)
    course = simulate(runs, sites, path, forward, backward, period_s=PERIOD_S, rng=np.random.default_rng(seed))
    for (recording, hand, trip_s), wall, worth in zip(varied, walls, _judged(course), strict=True):
        yield _row(name, "hands", recording, hand, 1e3 * trip_s, wall) | worth


def _leader_m(file: Path) -> Floats:
    """Return the depth of a recorded leader at each period, m: 0 at the median, positive where the hand strains."""
    leader_rad, hand_nm = recorded_columns(file, "leader_rad", "hand_torque_nm")
    away_rad = leader_rad - np.median(leader_rad)
    strains = -1.0 if float(np.sum(away_rad * np.abs(hand_nm))) < 0.0 else 1.0
    depth_m = strains * LEVER_M * away_rad
    # The hand first moves for half a second from the common start to the start of the recording.
    ramp = np.linspace(0.0, 1.0, 500)
    return np.concatenate((START_M + ramp * (depth_m[0] - START_M), depth_m))


def _wall_n_m(file: Path) -> float:
    """Return the stiffness of what a recorded hand touched, N/m, by its name; raise ValueError if that is unknown."""
    found = next((wall_n_m for word, wall_n_m in TOUCHED_N_M.items() if word in file.stem), None)
    if found is None:
        raise ValueError(f"{file}: the name contains none of {', '.join(TOUCHED_N_M)}")
    return found


def _row(name: str, kind: str, recording: str, hand: str, round_trip_ms: float, wall_n_m: float) -> dict[str, Any]:
    return {
        "architecture": name,
        "recorded": kind,
        "recording": recording,
        "hand": hand,
        "round_trip_ms": round_trip_ms,
        "wall_n_m": wall_n_m,
    }


def _judged(course: Course) -> Iterator[dict[str, Any]]:
    peaks = np.abs(course.shown_n).max(axis=0)
    for produced, peak_n in zip(produced_j(course).tolist(), peaks.tolist(), strict=True):
        yield {"produced_mj": 1e3 * produced, "peak_n": peak_n}
