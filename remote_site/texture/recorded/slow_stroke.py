"""Finds roughness and the period of the clearest line in a stroke recorded too slowly to show single grooves."""

import numpy as np

from common.wire.messages import ExplorationMode
from remote_site.texture.recorded.spatial_period import spatial_period
from remote_site.texture.recorded.stroke_path import longest_way
from remote_site.texture.recorded.stroke_segment import Segment
from remote_site.traces.trace_files import StrokeTrace

TREND = 4
"""Degree of the polynomial that models tilt, drift and the arm's slow swing, which are not roughness."""


def slow_stroke(trace: StrokeTrace, speed_m_s: float | None, whole: StrokeTrace | None = None) -> Segment:
    """Return one stroking segment for a recording too slow for the online identification.

    Args:
        trace: the recording. Of several signals, the one with the clearest line is used; without a line, the one that
            varies most.
        speed_m_s: speed if the recording has none, m/s.
        whole: all signals of the sensor, where `trace` has their mean; they show a motion of the whole sensor.
    """
    path = longest_way(trace, speed_m_s)
    found, speed = None, speed_m_s
    if path is not None:
        every = None if whole is None else whole.signals[path[1]]
        found = spatial_period(path[0], trace.signals[path[1]], every)
        if trace.speed_m_s is not None:
            speed = float(np.abs(trace.speed_m_s[path[1]]).mean())
    along = np.linspace(-1.0, 1.0, len(trace.time_s))
    trend = np.polynomial.legendre.legvander(along, TREND)
    lively = np.abs(trace.signals - trend @ np.linalg.lstsq(trend, trace.signals, rcond=None)[0]).mean(axis=0)
    chosen = int(np.argmax(lively)) if found is None else found[1]
    return Segment(
        ExplorationMode.STROKING,
        float(trace.time_s[0]),
        float(trace.time_s[-1]),
        roughness_v=float(lively[chosen]),
        force_n=None if trace.force_n is None else float(trace.force_n.mean()),
        speed_m_s=speed,
        period=None if found is None else found[0],
    )
