"""A stroke recorded too slowly to show single grooves: roughness and the period of its clearest line."""

import numpy as np
from numpy.typing import NDArray

from common.messages import ExplorationMode
from remote_site.spatial_period import spatial_period
from remote_site.stroke_segment import Segment
from remote_site.traces import StrokeTrace

REST = 0.1
"""A finger slower than this part of its highest speed rests."""
TREND = 4
"""Degree of the polynomial that is no roughness: tilt, drift and the arm's slow swing."""


def slow_stroke(trace: StrokeTrace, speed_m_s: float | None) -> Segment:
    """One stroking segment of a recording too slow for the online identification.

    Args:
        trace: the recording; of several signals the one that shows a line best is used, without a line the liveliest.
        speed_m_s: speed where the recording has none, m/s.
    """
    travelled = _travelled(trace, speed_m_s)
    found = None if travelled is None else spatial_period(travelled[0], trace.signals[travelled[1]])
    along = np.linspace(-1.0, 1.0, len(trace.time_s))
    trend = np.polynomial.legendre.legvander(along, TREND)
    lively = np.abs(trace.signals - trend @ np.linalg.lstsq(trend, trace.signals, rcond=None)[0]).mean(axis=0)
    chosen = int(np.argmax(lively)) if found is None else found[1]
    speed = trace.speed_m_s
    return Segment(
        ExplorationMode.STROKING,
        float(trace.time_s[0]),
        float(trace.time_s[-1]),
        roughness_v=float(lively[chosen]),
        force_n=None if trace.force_n is None else float(trace.force_n.mean()),
        speed_m_s=speed_m_s if speed is None else float(speed.mean()),
        period=None if found is None else found[0],
    )


def _travelled(trace: StrokeTrace, speed_m_s: float | None) -> tuple[NDArray[np.float64], NDArray[np.bool_]] | None:
    """Where each sample was taken along the stroke, m, and which samples those are: not the ones at rest.

    None where nothing is known of the speed, or nothing moves.
    """
    if trace.speed_m_s is None:
        return None if speed_m_s is None else (speed_m_s * trace.time_s, np.full(len(trace.time_s), True))
    speed = np.abs(trace.speed_m_s)
    moving = speed > REST * speed.max()
    steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(trace.time_s)
    path_m = np.concatenate(([0.0], np.cumsum(np.where(moving[1:], steps, 0.0))))[moving]
    return (path_m, moving) if len(path_m) > 1 else None
