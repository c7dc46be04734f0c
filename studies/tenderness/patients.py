"""Simulated patients: a tender place, a reaction time, and answers that are sometimes wrong.

It shares no code with the estimator.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
STEP_S = 0.02
"""Time between two samples of a press, s."""
SIDE_M = 0.048
"""Side of the examined square, from the first place of the raster to the last, m."""
MARGIN_M = 0.008
"""Least distance of a centre from the edge of the square, m."""
LET_GO_S = 0.3
"""Time after a report at which the examiner begins to lift the finger, s."""
LIFT_N_S = 8.0
"""Rate at which a lifted finger's force falls, N/s."""
REST_S = 2.0
"""Time between two presses, s; all answers have ended by then."""


@dataclass(frozen=True, slots=True)
class Kind:
    """How the patients of one condition differ from the usual ones.

    Attributes:
        name: of the condition.
        places: number of tender places.
        reaction_s: range of the mean reaction time, s.
        drift: growth of the reaction time over the examination, as a share.
        lasting_s: mean duration of pain after its cause has ended, s.
        noise: spread of the threshold between presses, as a share.
        wrong: share of presses with a report without a cause.
        presses_a_side: places along each side of the raster.
        rounds: rounds of 25 presses around the reported place.
    """

    name: str
    places: int = 1
    reaction_s: tuple[float, float] = (0.3, 1.2)
    drift: float = 0.0
    lasting_s: float = 0.0
    noise: float = 0.2
    wrong: float = 0.005
    presses_a_side: int = 7
    rounds: int = 2


@dataclass(frozen=True, slots=True)
class Pressed:
    """One simulated press.

    Attributes:
        time_s, force_n, answer: samples, the last one without contact.
        exceeded: whether the force has exceeded the threshold of this press.
    """

    time_s: Floats
    force_n: Floats
    answer: Floats
    exceeded: bool


class Patient:
    """One simulated patient.

    Attributes:
        centres_m: tender places, shape (places, 2), the most tender first.
        threshold_n: mean threshold at the most tender place, N.
        reaction_s: mean reaction time, s.
    """

    def __init__(self, kind: Kind, seed: int) -> None:
        self._kind = kind
        self._rng = rng = np.random.default_rng([seed, 74])
        self.reaction_s = float(rng.uniform(*kind.reaction_s))
        self.threshold_n = float(rng.uniform(1.0, 3.0))
        self._surround_n = self.threshold_n * float(rng.uniform(1.8, 4.0))
        self._width_m = float(rng.uniform(0.007, 0.013))
        self._gain = float(rng.uniform(4.0, 12.0))
        self._false, self._missed = kind.wrong, 0.03
        inside = (MARGIN_M, SIDE_M - MARGIN_M)
        self.centres_m = rng.uniform(*inside, (kind.places, 2))
        while kind.places == 2 and math.dist(*self.centres_m) < 0.02:
            self.centres_m = rng.uniform(*inside, (kind.places, 2))
        self._pressed = 0

    def mean_threshold_n(self, x_m: float, y_m: float) -> float:
        """Return the mean threshold at a place, N; a second place is 15 % less tender."""
        lowest = 1.0
        for number, (cx_m, cy_m) in enumerate(self.centres_m):
            near = math.exp(-0.5 * ((x_m - cx_m) ** 2 + (y_m - cy_m) ** 2) / self._width_m**2)
            depth = 1.0 - self.threshold_n * (1.0 + 0.15 * number) / self._surround_n
            lowest = min(lowest, 1.0 - depth * near)
        return self._surround_n * lowest

    def press(self, start_s: float, x_m: float, y_m: float, level_n: float) -> Pressed:
        """Press with a rising force up to a level, hold, and lift; the patient's report ends the press early."""
        rng = self._rng
        threshold_n = self.mean_threshold_n(x_m, y_m) * math.exp(self._kind.noise * rng.standard_normal())
        slow = 1.0 + self._kind.drift * min(1.0, self._pressed / 300.0)
        self._pressed += 1
        rate_n_s, hold_s = float(rng.uniform(0.7, 2.0)), float(rng.uniform(0.2, 0.8))
        reaction_s, end_reaction_s = slow * self.reaction_s * np.exp(0.1 * rng.standard_normal(2))
        lasting_s = float(rng.exponential(self._kind.lasting_s)) if self._kind.lasting_s else 0.0
        false, missed = rng.random() < self._false, rng.random() < self._missed
        top_s = level_n / rate_n_s
        lift_s = top_s + hold_s
        begin_s = math.inf
        if threshold_n < level_n and not missed:
            begin_s = threshold_n / rate_n_s + reaction_s
        if false:
            begin_s = min(begin_s, float(rng.uniform(0.0, lift_s)) + reaction_s)
        lift_s = min(lift_s, begin_s + LET_GO_S)
        reached_n = min(level_n, rate_n_s * lift_s)
        relief_s = lift_s + max(0.0, reached_n - threshold_n) / LIFT_N_S
        end_s = max(begin_s + 0.2, relief_s + lasting_s + end_reaction_s)
        over_s = lift_s + reached_n / LIFT_N_S
        last_s = max(over_s, end_s if begin_s < math.inf else 0.0) + 2.0 * STEP_S
        time_s = np.arange(0.0, last_s, STEP_S)
        force_n = np.minimum(rate_n_s * time_s, level_n)
        force_n = np.where(time_s > lift_s, reached_n - LIFT_N_S * (time_s - lift_s), force_n)
        force_n = np.maximum(force_n, 0.0) + 0.01 * rng.standard_normal(time_s.size)
        worst = 2.0 + self._gain * max(0.0, reached_n / threshold_n - 1.0)
        answer = np.where((time_s >= begin_s) & (time_s < end_s), min(10.0, round(worst)), 0.0)
        return Pressed(start_s + time_s, force_n, answer, bool(reached_n > threshold_n))
