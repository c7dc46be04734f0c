"""Finds the newest packet at each tick on one way of a latest-only link with delay, jitter and loss."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_ROUNDING = 1e-6


def newest(delay_s: Floats, lost: NDArray[np.bool_], period_s: float) -> Ints:
    """Return the sending tick of the newest arrived packet at each tick, (ticks, N); -1 before the first.

    A packet is sent at every tick. An overtaken packet is dropped, as on the real link.

    Args:
        delay_s: delay of the packet sent at each tick, (ticks, N).
        lost: True for packets that never arrive, (ticks, N).
        period_s: period of the ticks.
    """
    ticks, runs = delay_s.shape
    sent = np.arange(ticks)[:, None]
    arrives = sent + np.ceil(delay_s / period_s - _ROUNDING).astype(np.int64)
    there = ~lost & (arrives < ticks)
    latest = np.full((ticks, runs), -1, dtype=np.int64)
    run = np.broadcast_to(np.arange(runs), (ticks, runs))
    np.maximum.at(latest, (arrives[there], run[there]), np.broadcast_to(sent, (ticks, runs))[there])
    return np.maximum.accumulate(latest, axis=0)


def way(
    ticks: int, period_s: float, round_trip_s: Floats, jitter_s: Floats, loss: Floats, rng: np.random.Generator
) -> Ints:
    """Return the newest packets on one way of links with half of the round trip, (ticks, N), as `newest` does.

    Args:
        ticks: number of ticks.
        period_s: period of the ticks.
        round_trip_s: round trip without jitter, (N,).
        jitter_s: mean of the exponentially distributed additional delay of a packet, (N,).
        loss: share of lost packets, 0..1, (N,).
        rng: random generator of jitter and loss.
    """
    shape = (ticks, len(round_trip_s))
    late_s = rng.standard_exponential(shape) * jitter_s
    return newest(0.5 * round_trip_s + late_s, rng.random(shape) < loss, period_s)
