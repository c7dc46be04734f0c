"""Calculates and simulates the largest stable stiffness of the sampled wall and of direct position-force control.

The calculation takes the loop L(jw) from position to force to position. L has the delay of the link, the two holds of a
period, and the servo on the wall. The loop is stable if the curve of 1 + L does not wind around 0 (Nyquist's criterion;
hand and servo alone are stable). The model is linear, continuous except for its holds, and always in contact. The
simulation runs `plant` on a grid of walls.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_sensors.physics.fingertip import MASS_KG, SERVO_N_M, SERVO_NS_M
from studies.teleoperation_stability.cases import DEVICE_KG, DEVICE_NS_M, WALL_NS_M, Floats, Hand, cases
from studies.teleoperation_stability.direct import DirectForce
from studies.teleoperation_stability.measures import FIRM_N, START_M, swing
from studies.teleoperation_stability.network import way
from studies.teleoperation_stability.plant import simulate

SOFTEST_N_M, HARDEST_N_M = 20.0, 20_000.0
FREE = Hand(0.0, 0.0, 0.0)
"""Impedance without a hand: only the device, with inertia and its own damping."""
_GRID = 12
_WATCH_S, _WATCH_ROUND_TRIPS = 3.0, 20.0
_OMEGA = np.concatenate(([0.0], np.geomspace(0.1, 3000.0, 6000)))


@dataclass(frozen=True, slots=True)
class Loop:
    """Loop of one hand over one link.

    Attributes:
        hand: hand that moves the exoskeleton.
        round_trip_s: round trip of the link.
        period_s: period of both sites.
    """

    hand: Hand
    round_trip_s: float
    period_s: float

    @property
    def delay_s(self) -> float:
        """Delay of the link in whole ticks, s: to the remote site, and at least one period back."""
        one_way = np.ceil(0.5 * self.round_trip_s / self.period_s - 1e-6)
        return float((one_way + max(1.0, one_way)) * self.period_s)


def largest(stable: Callable[[float], bool]) -> float | None:
    """Return the largest stable stiffness, N/m, to 0.5 %; None if the hardest is stable, 0 if the softest is not."""
    low, high = SOFTEST_N_M, HARDEST_N_M
    if not stable(low):
        return 0.0
    if stable(high):
        return None
    while high > 1.005 * low:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def worked_out_n_m(loop: Loop) -> float | None:
    """Return the largest stable wall of direct position-force control by Nyquist's criterion, as `largest` does."""
    s = 1j * _OMEGA
    hand = (loop.hand.kg + DEVICE_KG) * s * s + (loop.hand.ns_m + DEVICE_NS_M) * s + loop.hand.n_m
    held = np.exp(-0.5 * s * loop.period_s) * np.sinc(_OMEGA * loop.period_s / (2.0 * np.pi))
    through = np.exp(-s * loop.delay_s) * held * held / hand

    def stable(wall_n_m: float) -> bool:
        wall = wall_n_m + WALL_NS_M * s
        remote = SERVO_N_M * wall / (MASS_KG * s * s + SERVO_NS_M * s + SERVO_N_M + wall)
        return not _winds(1.0 + through * remote)

    return largest(stable)


def sampled_wall_n_m(hand: Hand, period_s: float) -> float | None:
    """Return the largest stable virtual wall of the device itself with one hold, by Nyquist's criterion."""
    s = 1j * _OMEGA[1:]
    place = (hand.kg + DEVICE_KG) * s * s + (hand.ns_m + DEVICE_NS_M) * s + hand.n_m
    held = np.exp(-0.5 * s * period_s) * np.sinc(_OMEGA[1:] * period_s / (2.0 * np.pi))
    return largest(lambda wall_n_m: not _winds(1.0 + wall_n_m * held / place, free=hand.n_m == 0.0))


def _winds(curve: NDArray[np.complex128], free: bool = False) -> bool:
    """Return whether a curve from w = 0 to infinity winds around 0; a free mass begins a quarter turn away."""
    turned = float(np.sum(np.angle(curve[1:] / curve[:-1])))
    begun = float(np.angle(curve[0])) if free else 0.0
    return abs(turned + begun) > 1.0


def simulated_n_m(loops: list[Loop], seed: int = 0) -> list[float | None]:
    """Return the largest wall at which direct position-force control comes to rest, N/m, to 3 %.

    The result is None if the hardest wall comes to rest. All walls run at once, in two grids. The softest wall that
    oscillates sets the limit, even if a harder one comes to rest. An oscillation grows once per round trip, so a longer
    round trip is watched for longer. All loops must have the same period.
    """
    rows = np.arange(len(loops))
    low, high = np.full((2, len(loops)), [[SOFTEST_N_M], [HARDEST_N_M]])
    for _ in range(2):
        walls = low * (high / low) ** np.linspace(0.0, 1.0, _GRID)[:, None]
        rest = _rest(loops, walls, seed)
        first = np.where(rest.all(axis=0), _GRID - 1, np.argmin(rest, axis=0))
        low, high = walls[np.where(rest.all(axis=0), first, np.maximum(0, first - 1)), rows], walls[first, rows]
    return [None if a >= 0.99 * HARDEST_N_M else float(np.sqrt(a * b)) for a, b in zip(low, high, strict=True)]


def _rest(loops: list[Loop], walls_n_m: Floats, seed: int) -> NDArray[np.bool_]:
    """Return which walls come to rest, (walls, loops)."""
    period_s = loops[0].period_s
    runs = cases(
        (loop.hand, wall_n_m, 0.0) for row in walls_n_m.tolist() for loop, wall_n_m in zip(loops, row, strict=True)
    )
    round_trip_s = np.tile([loop.round_trip_s for loop in loops], len(walls_n_m))
    watch_s = _WATCH_S + _WATCH_ROUND_TRIPS * float(round_trip_s.max())
    none, rng = np.zeros(len(runs)), np.random.default_rng(seed)
    one_way = way(round((1.0 + watch_s) / period_s), period_s, round_trip_s, none, none, rng)
    pressed_m = FIRM_N * (1.0 / runs.wall_n_m + 1.0 / runs.hand_n_m)

    def path(t_s: float) -> tuple[Floats, Floats]:
        left = max(0.0, 1.0 - t_s)
        return pressed_m + left * (START_M - pressed_m), (pressed_m - START_M) * (left > 0.0)

    course = simulate(runs, DirectForce(none + START_M), path, one_way, one_way, period_s=period_s, rng=rng)
    amplitude_m = swing(course, (1.0 + 0.4 * watch_s, 1.0 + watch_s))[0]
    return np.asarray(amplitude_m == 0.0).reshape(walls_n_m.shape)


def simulated_wall_n_m(period_s: float) -> float | None:
    """Return the largest virtual wall on the device itself that comes to rest in simulation, as `largest` does."""
    return largest(lambda wall_n_m: _wall_rests(wall_n_m, period_s))


def _wall_rests(wall_n_m: float, period_s: float) -> bool:
    """Return whether a device released inside a wall comes to rest, always in contact, with force held per period."""
    x, v, step_s = 1e-3, 0.0, 1e-5 * max(1.0, period_s / 1e-3)
    seconds, seen = 3.0, [0.0, 0.0]
    steps = round(period_s / step_s)
    ticks = round(seconds / period_s)
    for tick in range(ticks):
        force_n = wall_n_m * x
        for _ in range(steps):
            v = (v - step_s / DEVICE_KG * force_n) / (1.0 + step_s * DEVICE_NS_M / DEVICE_KG)
            x += step_s * v
        if tick >= ticks // 3:
            part = tick >= 2 * ticks // 3
            seen[part] = max(seen[part], abs(x))
        if abs(x) > 1.0:
            return False
    return seen[1] < seen[0]
