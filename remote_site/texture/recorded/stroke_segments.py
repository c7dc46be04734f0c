"""Cuts a recorded stroke where the mode or the surface changes, and identifies each part."""

from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from common.wire.messages import ExplorationMode
from remote_site.texture.groove_period import GroovePeriod, Period
from remote_site.texture.motion_spectrum import StrokeSpectrum
from remote_site.texture.recorded.spatial_period import spatial_period
from remote_site.texture.recorded.stroke_path import longest_way
from remote_site.texture.recorded.stroke_playback import FAST_HZ, EvenStroke, StrokeBlock, even_stroke, felt
from remote_site.texture.recorded.stroke_spectrum import stroke_spectrum
from remote_site.texture.surface_table import SurfaceTable
from remote_site.texture.tip_path import RATE_HZ
from remote_site.traces.trace_files import StrokeTrace


@dataclass(slots=True)
class Segment:
    """Part of a stroke in one mode on one surface.

    Attributes:
        mode: exploration mode.
        start_s: begin, s.
        end_s: end, s.
        roughness_v: roughness without grooves, V (or the signal's own unit); None if unknown.
        force_n: mean force, N; None if not recorded.
        speed_m_s: mean speed in either direction, m/s, of a slow recording only where it moves; None if unknown.
        impulses_s: times of grooves and edges, s.
        strengths_v: curvatures of these grooves and edges for one newton, V.
        period: spatial period; None without a period or a known speed.
        surface: name of the likeliest surface; None without a table or a stroke.
        spectrum: spectrum of the vibration; None without a stroke of 0.128 s or more.
        changed: whether the segment begins where the stroke reached another surface.
        fault: fault of the sensor; None without a fault.
    """

    mode: ExplorationMode
    start_s: float
    end_s: float
    roughness_v: float | None = None
    force_n: float | None = None
    speed_m_s: float | None = None
    impulses_s: list[float] = field(default_factory=list)
    strengths_v: list[float] = field(default_factory=list)
    period: Period | None = None
    surface: str | None = None
    spectrum: StrokeSpectrum | None = None
    changed: bool = False
    fault: str | None = None


def segments(
    trace: StrokeTrace, surfaces: SurfaceTable, speed_m_s: float | None = None, whole: StrokeTrace | None = None
) -> list[Segment]:
    """Cut a stroke into its segments in contact.

    A recording without force counts as in contact throughout. A recording without speed counts as stroking.

    Args:
        trace: the recording. Of several signals, a slow recording uses the one with the clearest period, a fast one
            the one that varies most.
        surfaces: law of the sensor and calibrated surfaces.
        speed_m_s: speed if the recording has none, m/s.
        whole: all signals of a slow recording, where `trace` has their mean.
    """
    if trace.rate_hz < FAST_HZ:
        return [slow_stroke(trace, speed_m_s, whole)]
    found = even_segments(even_stroke(trace, speed_m_s), surfaces)
    for segment in found:
        if trace.force_n is None:
            segment.force_n = None
        if trace.speed_m_s is None and speed_m_s is None:
            segment.speed_m_s = segment.period = None
    return found


def even_segments(stroke: EvenStroke, surfaces: SurfaceTable) -> list[Segment]:
    """Return the segments in contact of a stroke at the sensor's rate."""
    found = [_segment(part, stroke) for part in _parts(stroke, surfaces) if part[0].mode is not ExplorationMode.FREE]
    for segment in found:
        inside = (stroke.time_s >= segment.start_s) & (stroke.time_s <= segment.end_s)
        segment.force_n = float(stroke.force_n[inside].mean())
        segment.speed_m_s = float(stroke.speed_m_s[inside].mean())
        if segment.mode is ExplorationMode.STROKING:
            signal_v = stroke.signal_v[inside]
            segment.spectrum = stroke_spectrum(signal_v, RATE_HZ, segment.speed_m_s, segment.force_n)
    return found


def _parts(stroke: EvenStroke, surfaces: SurfaceTable) -> list[list[StrokeBlock]]:
    """Return the blocks in groups of one mode and one surface; none for a stroke shorter than a block."""
    blocks = list(felt(stroke, surfaces))
    cuts = [0] if blocks else []
    for number, (before, block) in enumerate(pairwise(blocks), start=1):
        stroking = block.mode is ExplorationMode.STROKING
        if block.mode is not before.mode or (stroking and block.texture.changed_s is not None):
            cuts.append(number)
    return [blocks[first:last] for first, last in pairwise([*cuts, len(blocks)])]


def _segment(part: list[StrokeBlock], stroke: EvenStroke) -> Segment:
    """Summarise consecutive blocks of one mode; roughness and surface come from the later two thirds."""
    segment = Segment(part[0].mode, part[0].begin_s, part[-1].end_s)
    segment.fault = next((block.texture.fault for block in part if block.texture.fault is not None), None)
    if segment.mode is not ExplorationMode.STROKING:
        return segment
    segment.changed = part[0].texture.changed_s is not None
    impulses = [impulse for block in part for impulse in block.texture.impulses]
    segment.impulses_s = [round(impulse.time_s, 4) for impulse in impulses]
    segment.strengths_v = [impulse.strength_v for impulse in impulses]
    settled = [block.texture for block in part[len(part) // 3 :] if block.texture.valid]
    if settled and segment.fault is None:
        segment.roughness_v = float(np.sqrt(np.mean([texture.roughness_v**2 for texture in settled])))
        ((segment.surface, _),) = Counter(texture.best for texture in settled).most_common(1)
    period, along_m = GroovePeriod(), stroke.along_m
    for block in part:
        for impulse in block.texture.impulses:
            period.groove(impulse.place_m, (float(np.interp(impulse.time_s, stroke.time_s, along_m)), 0.0))
        if block.texture.fault is not None:
            period.interrupt()  # after a fault, the path begins again
    segment.period = period.estimate()
    return segment


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
