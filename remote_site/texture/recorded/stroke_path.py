"""Computes the path of a recorded stroke from its times and its speed."""

import numpy as np
from numpy.typing import NDArray

from remote_site.traces.trace_files import StrokeTrace

Array = NDArray[np.float64]

REST = 0.1
"""Fraction of its highest speed below which a finger rests."""


def travelled(trace: StrokeTrace, speed_m_s: float | None) -> tuple[Array, NDArray[np.bool_]] | None:
    """Return the places of the moving samples along the stroke, m, and a mask of these samples.

    The result is None if the speed is unknown, or nothing moves.
    """
    if trace.speed_m_s is None:
        return None if speed_m_s is None else (speed_m_s * trace.time_s, np.full(len(trace.time_s), True))
    speed = np.abs(trace.speed_m_s)
    moving = speed > REST * speed.max()
    steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(trace.time_s)
    path_m = np.concatenate(([0.0], np.cumsum(np.where(moving[1:], steps, 0.0))))[moving]
    return (path_m, moving) if len(path_m) > 1 else None


def longest_way(trace: StrokeTrace, speed_m_s: float | None) -> tuple[Array, NDArray[np.bool_]] | None:
    """Return the same as `travelled` of the longest way between two turns: a turn breaks a pattern's line."""
    found = travelled(trace, speed_m_s)
    if found is None or trace.speed_m_s is None:
        return found
    path_m, moving = found
    turns = np.flatnonzero(np.diff(np.sign(trace.speed_m_s[moving]))) + 1
    ways = np.split(np.arange(len(path_m)), turns)
    longest = max(ways, key=lambda way: float(path_m[way[-1]] - path_m[way[0]]))
    mask = np.zeros(len(moving), dtype=np.bool_)
    mask[np.flatnonzero(moving)[longest]] = True
    return (path_m[longest], mask) if len(longest) > 1 else None
