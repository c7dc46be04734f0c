"""Which packet is the newest one at each tick: delay, jitter and loss of one way of a latest-only link."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_ROUNDING = 1e-6


def newest(delay_s: Floats, lost: NDArray[np.bool_], period_s: float) -> Ints:
    """Tick at which the newest packet that is there was sent, (ticks, N); -1 before the first.

    A packet is sent at every tick. One that a later one has overtaken is dropped, as the real link does.

    Args:
        delay_s: of the packet sent at each tick, (ticks, N).
        lost: which packets never arrive, (ticks, N).
        period_s: of the ticks.
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
    """One way of links with half of the round trip each, (ticks, N).

    Args:
        ticks: how many.
        period_s: of the ticks.
        round_trip_s: without jitter, (N,).
        jitter_s: mean of what a packet is late beyond that, exponentially distributed, (N,).
        loss: share of packets lost, (N,).
        rng: of jitter and loss.
    """
    shape = (ticks, len(round_trip_s))
    late_s = rng.standard_exponential(shape) * jitter_s
    return newest(0.5 * round_trip_s + late_s, rng.random(shape) < loss, period_s)
