"""Measures a run: energy, oscillation, peak force, and errors of position, force and stiffness."""

import math
from typing import Any

import numpy as np

from studies.teleoperation_stability.cases import Cases, Floats
from studies.teleoperation_stability.plant import Course

START_M = -0.005
LIGHT_N, FIRM_N = 1.0, 2.0
"""Intended force of the hand's first and second press, N; afterwards it lets go."""
SECONDS = 6.0
FIRST_HOLD, SECOND_HOLD, QUIET = (1.6, 2.0), (4.0, 5.0), (3.4, 5.0)
"""Times over which positions and forces are averaged, and time without intended motion, s; breathing ends before."""
PRODUCED_J = 0.001
"""Largest energy that a passive run may produce, J."""
SWING_M = 1e-4
LASTING = 0.85
"""Least ratio of the amplitudes in the second and first half of QUIET at which an oscillation counts as lasting."""
FORCE_MOST_N = 10.0
_TURNS = ((0.0, 0.6), (2.0, 2.4), (5.0, 5.6))


class PressTwice:
    """A hand's intended minimum-jerk path: down to a light press, down to a firm press, and off again."""

    def __init__(self, runs: Cases) -> None:
        softness = 1.0 / np.where(runs.wall_n_m > 0.0, runs.wall_n_m, math.inf) + 1.0 / runs.hand_n_m
        self._places = np.stack(
            (np.full(len(runs), START_M), LIGHT_N * softness, FIRM_N * softness, np.full(len(runs), START_M))
        )

    def __call__(self, t_s: float) -> tuple[Floats, Floats]:
        """Return intended position, m, and speed, m/s, (N,)."""
        place, pace = self._places[0], np.zeros_like(self._places[0])
        for (begins_s, ends_s), way in zip(_TURNS, np.diff(self._places, axis=0), strict=True):
            part = min(1.0, max(0.0, (t_s - begins_s) / (ends_s - begins_s)))
            place = place + way * part**3 * (10.0 - 15.0 * part + 6.0 * part**2)
            pace = pace + way * 30.0 * part**2 * (1.0 - part) ** 2 / (ends_s - begins_s)
        return place, pace


def swing(course: Course, between_s: tuple[float, float] = QUIET) -> tuple[Floats, Floats]:
    """Return amplitude, m, and frequency, Hz, of each run's lasting oscillation, (N,); 0 without one."""
    first, last = (round(t_s / course.period_s) for t_s in between_s)
    depth = course.depth_m[first:last]
    t_s = course.period_s * np.arange(first, last)
    columns = np.stack((np.ones_like(t_s), t_s), axis=1)
    rest = depth - columns @ np.linalg.lstsq(columns, depth, rcond=None)[0]
    half = len(rest) // 2
    before, after = (0.5 * np.ptp(part, axis=0) for part in (rest[:half], rest[half:]))
    lasting = (after > SWING_M) & (after > LASTING * before)
    crossings = np.count_nonzero(np.diff(np.signbit(rest), axis=0), axis=0)
    lasting &= crossings >= 3
    return np.where(lasting, after, 0.0), np.where(lasting, 0.5 * crossings / (between_s[1] - between_s[0]), 0.0)


def produced_j(course: Course) -> Floats:
    """Return the largest net energy output at the operator's finger, less the moving wall's work, J, (N,)."""
    return np.asarray(np.max(course.given_j - np.maximum(0.0, course.wall_j), axis=0))


def measure(course: Course) -> list[dict[str, Any]]:
    """Return a row for each run that pressed twice."""

    def mean(values: Floats, span: tuple[float, float]) -> Floats:
        first, last = (round(t_s / course.period_s) for t_s in span)
        return np.asarray(values[first:last].mean(axis=0))

    amplitude_m, frequency_hz = swing(course)
    produced = produced_j(course)
    pressed_m = mean(course.depth_m, SECOND_HOLD) - mean(course.depth_m, FIRST_HOLD)
    pressed_n = mean(course.shown_n, SECOND_HOLD) - mean(course.shown_n, FIRST_HOLD)
    felt_n_m = np.where(pressed_m > 1e-4, pressed_n / np.where(pressed_m > 1e-4, pressed_m, 1.0), np.nan)
    columns = {
        "produced_mj": 1e3 * produced,
        "swing_mm": 1e3 * amplitude_m,
        "swing_hz": frequency_hz,
        "peak_n": np.abs(course.shown_n).max(axis=0),
        "remote_peak_n": course.contact_n.max(axis=0),
        "felt_n_m": felt_n_m,
        "place_error_mm": 1e3 * (mean(course.depth_m, SECOND_HOLD) - mean(course.remote_m, SECOND_HOLD)),
        "force_error_n": mean(course.shown_n, SECOND_HOLD) - mean(course.contact_n, SECOND_HOLD),
    }
    rows = []
    for values in zip(*columns.values(), strict=True):
        row = {name: None if math.isnan(value) else float(value) for name, value in zip(columns, values, strict=True)}
        row["stable"] = row["swing_mm"] == 0.0
        rows.append(row)
    return rows
