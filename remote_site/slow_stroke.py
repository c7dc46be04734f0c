"""A stroke recorded too slowly to show single grooves: roughness and the period of its strongest line."""

import numpy as np

from common.messages import ExplorationMode
from remote_site.spatial_period import spatial_period
from remote_site.stroke_segment import Segment
from remote_site.traces import StrokeTrace


def slow_stroke(trace: StrokeTrace, speed_m_s: float | None) -> Segment:
    """One stroking segment of a recording too slow for the online identification."""
    speed = float(trace.speed_m_s.mean()) if trace.speed_m_s is not None else speed_m_s
    even_s = np.linspace(trace.time_s[0], trace.time_s[-1], len(trace.time_s))
    signals = [np.interp(even_s, trace.time_s, column) for column in trace.signals.T]
    found = [spatial_period(signal, speed / trace.rate_hz) if speed else None for signal in signals]
    lines = [(line[1], line[0], k) for k, line in enumerate(found) if line is not None]
    best = max(lines, key=lambda line: line[0]) if lines else None
    chosen = signals[best[2] if best is not None else int(np.argmax([s.std() for s in signals]))]
    return Segment(
        ExplorationMode.STROKING,
        float(trace.time_s[0]),
        float(trace.time_s[-1]),
        roughness_v=float(np.abs(chosen - np.median(chosen)).mean()),
        force_n=None if trace.force_n is None else float(trace.force_n.mean()),
        speed_m_s=speed,
        period=None if best is None else best[1],
    )
