"""A recorded stroke cut into exploration modes, each with roughness, impulses and period."""

import numpy as np
from numpy.typing import NDArray

from common.exploration import Exploration
from common.messages import ExplorationMode
from remote_site.groove_period import GroovePeriod
from remote_site.roughness import LEAK_HZ, RATE_HZ, Roughness
from remote_site.slow_stroke import slow_stroke
from remote_site.stroke_segment import Segment
from remote_site.surface_class import NOMINAL_FORCE_N, NOMINAL_SPEED_M_S
from remote_site.traces import StrokeTrace

CHUNK = 10
FAST_HZ = 1000.0
"""Recordings from this rate on go through the online identification; slower ones cannot show single grooves."""


def segments(trace: StrokeTrace, speed_m_s: float | None = None) -> list[Segment]:
    """Cut a stroke into its segments in contact.

    A recording without force counts as in contact throughout, one without speed as stroking.

    Args:
        trace: the recording; of several signals the one with the clearest period is used.
        speed_m_s: speed where the recording has none, m/s.
    """
    if trace.rate_hz < FAST_HZ:
        return [slow_stroke(trace, speed_m_s)]
    return _fast(trace, speed_m_s)


def _fast(trace: StrokeTrace, speed_m_s: float | None) -> list[Segment]:
    """Segments by the online identification, chunk by chunk."""
    time_s = np.arange(trace.time_s[0], trace.time_s[-1], 1.0 / RATE_HZ)

    def even(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.interp(time_s, trace.time_s, values)

    signals = [even(column) for column in trace.signals.T]
    signal = max(signals, key=lambda s: float(np.abs(s - np.median(s)).mean()))
    force = None if trace.force_n is None else even(trace.force_n)
    given = trace.speed_m_s is not None or speed_m_s is not None
    constant = np.full(len(time_s), speed_m_s if speed_m_s is not None else NOMINAL_SPEED_M_S)
    speed = even(trace.speed_m_s) if trace.speed_m_s is not None else constant
    exploration, found = Exploration(), list[Segment]()
    # without a force channel nothing tells when the leaky integrator started
    roughness, period = Roughness(LEAK_HZ if force is not None else 0.0), GroovePeriod()
    x_m, readings = 0.0, list[float]()
    for first in range(0, len(time_s) - CHUNK + 1, CHUNK):
        last = first + CHUNK - 1
        t_s, v = float(time_s[last]), float(speed[last])
        f = NOMINAL_FORCE_N if force is None else float(force[last])
        x_m += v * CHUNK / RATE_HZ
        mode = exploration.step(t_s, f, x_m, 0.0, 0.0)
        reading = roughness.step(t_s, signal[first : last + 1], mode, v, f)
        if not found or found[-1].mode is not mode:
            _finish(found, readings, period, given)
            found.append(Segment(mode, float(time_s[first]), t_s))
            readings, period = [], GroovePeriod()
        part = found[-1]
        part.end_s = t_s
        period.move(v * CHUNK / RATE_HZ)
        if reading.impulse:
            part.impulses_s.append(round(t_s, 4))
            period.flag()
        if mode is ExplorationMode.STROKING and reading.valid:
            readings.append(reading.roughness_v)
    _finish(found, readings, period, given)
    for part in found:
        inside = (time_s >= part.start_s) & (time_s <= part.end_s)
        part.force_n = None if force is None else float(force[inside].mean())
        part.speed_m_s = float(speed[inside].mean()) if given else None
    return [part for part in found if part.mode is not ExplorationMode.FREE]


def _finish(found: list[Segment], readings: list[float], period: GroovePeriod, given: bool) -> None:
    """Close the last segment; its later readings have settled."""
    if found:
        settled = readings[len(readings) // 3 :]
        found[-1].roughness_v = float(np.mean(settled)) if settled else None
        found[-1].period = period.estimate() if given else None
