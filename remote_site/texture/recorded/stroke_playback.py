"""Plays a recorded stroke of a fast sensor through the online identification: mode and texture, block by block."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import resample_poly

from common.exploration.exploration_mode import ModeDetector
from common.exploration.hand_motion import HandMotion
from common.wire.messages import ExplorationMode
from remote_site.texture.sensor_fault import RAIL_V
from remote_site.texture.surface_table import SurfaceTable
from remote_site.texture.texture_identification import BLOCK, TextureIdentification, TextureReading
from remote_site.texture.texture_law import NOMINAL_FORCE_N, NOMINAL_SPEED_M_S
from remote_site.texture.tip_path import RATE_HZ
from remote_site.traces.trace_files import StrokeTrace

Array = NDArray[np.float64]
NEAR_RAIL = 0.998
"""Fraction of the largest value from which a sample is at the end of its range."""
FAST_HZ = 1000.0
"""Minimum sampling rate for the online identification, Hz; slower recordings cannot show single grooves."""


@dataclass(frozen=True, slots=True)
class EvenStroke:
    """A stroke at the sensor's rate, in arrays of one length; values that were not recorded are nominal.

    Attributes:
        time_s: times, s.
        signal_v: samples, V.
        force_n: contact force, N.
        speed_m_s: speed in either direction, m/s.
        direction: -1 backwards, else 1; one value for all samples, or one for each.
    """

    time_s: Array
    signal_v: Array
    force_n: Array
    speed_m_s: Array
    direction: Array | float = 1.0

    @property
    def along_m(self) -> Array:
        """Place of the finger along the stroke at each sample, m."""
        return np.asarray(np.cumsum(self.direction * self.speed_m_s) / RATE_HZ)


@dataclass(frozen=True, slots=True)
class StrokeBlock:
    """Result of one block: begin and end, s; mode; speed, m/s; force, N; whether a contact began; texture."""

    begin_s: float
    end_s: float
    mode: ExplorationMode
    speed_m_s: float
    force_n: float
    began: bool
    texture: TextureReading


def even_stroke(trace: StrokeTrace, speed_m_s: float | None = None) -> EvenStroke:
    """Resample a recording to the sensor's rate; of several signals, the one that varies most is used.

    A negative speed is a stroke backwards, and counts as a stroke. A low-pass filter removes what a faster recording
    has above half of the sensor's rate; otherwise it would appear as vibration of a lower frequency.

    Args:
        trace: the recording.
        speed_m_s: speed if the recording has none, m/s.
    """
    time_s = np.arange(trace.time_s[0], trace.time_s[-1], 1.0 / RATE_HZ)

    def even(values: Array | None, otherwise: float) -> Array:
        return np.full(len(time_s), otherwise) if values is None else np.interp(time_s, trace.time_s, values)

    signals = [_decimated(trace, column, time_s) for column in trace.signals.T]
    speed = None if trace.speed_m_s is None else np.abs(trace.speed_m_s)
    return EvenStroke(
        time_s,
        max(signals, key=lambda signal: float(np.abs(signal - np.median(signal)).mean())),
        even(trace.force_n, NOMINAL_FORCE_N),
        even(speed, NOMINAL_SPEED_M_S if speed_m_s is None else speed_m_s),
        1.0 if trace.speed_m_s is None else np.where(even(trace.speed_m_s, 0.0) < 0.0, -1.0, 1.0),
    )


def _decimated(trace: StrokeTrace, signal: Array, time_s: Array) -> Array:
    """Return a signal of a recording at the times of the sensor's samples, s."""
    times = round(trace.rate_hz / RATE_HZ)
    if times < 2:
        return np.interp(time_s, trace.time_s, signal)
    fine_s = time_s[0] + np.arange(times * len(time_s)) / (times * RATE_HZ)
    low_passed = resample_poly(np.interp(fine_s, trace.time_s, signal), 1, times, padtype="edge")
    # A filter overshoots beside a saturated sample.
    return np.asarray(np.clip(low_passed, signal.min(), signal.max()), dtype=np.float64)


def _rail_v(signal_v: Array) -> float:
    """Return the end of a sensor's range, V: that of the texture sensor, or of a signal beyond it the largest value."""
    return max(RAIL_V, NEAR_RAIL * float(np.abs(signal_v).max()))


def felt(stroke: EvenStroke, surfaces: SurfaceTable) -> Iterator[StrokeBlock]:
    """Yield the result of each block; a stroke without force counts as in contact, one without speed as stroking."""
    hand = HandMotion()
    exploration, identification = ModeDetector(hand), TextureIdentification(surfaces, _rail_v(stroke.signal_v))
    x_m = 0.0
    direction = np.broadcast_to(stroke.direction, len(stroke.time_s))
    for first in range(0, len(stroke.time_s) - BLOCK + 1, BLOCK):
        last = first + BLOCK - 1
        t_s, speed_m_s, force_n = float(stroke.time_s[last]), float(stroke.speed_m_s[last]), float(stroke.force_n[last])
        x_m += speed_m_s * BLOCK / RATE_HZ
        hand.step(t_s, x_m, 0.0)
        mode = exploration.step(t_s, force_n, 0.0)
        part = slice(first, last + 1)
        if direction[last] != direction[max(first - 1, 0)]:
            identification.interrupt()  # the finger turned, and crosses the same grooves again
        texture = identification.step(
            t_s, stroke.signal_v[part], stroke.force_n[part].tolist(), stroke.speed_m_s[part].tolist(), mode
        )
        yield StrokeBlock(float(stroke.time_s[first]), t_s, mode, speed_m_s, force_n, exploration.began, texture)
