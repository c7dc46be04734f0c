"""One remote finger on its servo over an object, as the site sees it: rounded, noisy, and some frames late."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sim_sensors.physics.fingertip import Fingertip
from sim_sensors.physics.remote_world import FORCE_NOISE_N

TICK_S = 0.002
COUNT_M, SET_COUNT_M, COUNT_N = 5e-6, 2e-5, 0.01
HOVER_M = 0.006


@dataclass(frozen=True, slots=True)
class Seen:
    """What is measured at a tick, and the set-point that is sent in it."""

    t_s: float
    height_m: float
    force_n: float
    set_m: float


def rounded(value: float, step: float) -> float:
    return round(value / step) * step


def follow(set_m: Iterator[float], stiffness_n_m: float, seed: int, late: int = 2) -> Iterator[Seen]:
    """What is seen of a finger that is sent along a path over an object whose surface is at 0.

    Args:
        set_m: wanted height at each tick, m.
        stiffness_n_m: of the object.
        seed: of the noise.
        late: ticks from a set-point to its servo, and from a reading to the site.
    """
    tip, noise = Fingertip(HOVER_M), np.random.default_rng(seed)
    sent = deque([HOVER_M] * late, maxlen=late)
    seen = deque([(HOVER_M, 0.0)] * late, maxlen=late)
    for tick, wanted_m in enumerate(set_m):
        tip.step(TICK_S, rounded(sent[0], SET_COUNT_M), 0.0, stiffness_n_m)
        height_m, force_n = seen[0]
        reads_n = max(0.0, tip.force_n + FORCE_NOISE_N * noise.standard_normal())
        seen.append((rounded(tip.z_m, COUNT_M), rounded(reads_n, COUNT_N)))
        sent.append(wanted_m)
        yield Seen(tick * TICK_S, height_m, force_n, wanted_m)


def presses(seed: int, seconds: float, deepest_m: float = -0.005) -> Iterator[float]:
    """A hand that goes up and down at random, as fast as the gate lets it, rests between, and trembles."""
    random = np.random.default_rng(seed)
    height_m, goal_m, speed_m_s, rest_s, t_s = HOVER_M, HOVER_M, 0.1, 0.0, 0.0
    while t_s < seconds:
        t_s += TICK_S
        if abs(goal_m - height_m) < 1e-9:
            rest_s -= TICK_S
            if rest_s <= 0.0:
                goal_m, speed_m_s = random.uniform(deepest_m, HOVER_M), random.uniform(0.01, 0.1)
                rest_s = random.uniform(0.0, 1.5)
        step_m = speed_m_s * TICK_S
        height_m += min(step_m, max(-step_m, goal_m - height_m))
        yield height_m + 2e-5 * float(np.sin(2 * np.pi * 9.3 * t_s)) + 1e-4 * float(np.sin(2 * np.pi * 0.23 * t_s))
