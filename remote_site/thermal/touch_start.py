"""Finds the start of a recorded touch as the online identification does: start, ambient, readings in contact."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from remote_site.traces.trace_files import ThermalTrace

READING_S = 0.01
"""Period of the thermal sensor's readings, s."""
FASTER = 0.4
"""Median step of a trace, in READING_S, below which its samples are averaged over READING_S."""
BEFORE = 5
"""Number of readings in the mean before contact if there are too few for a slope (50 ms)."""
SHORT, WARMING = 25, 50
"""Numbers of readings before contact in the short and the long line fit of the plate (0.25 and 0.5 s at 100 Hz)."""
AGREE_SD = 2.0
"""Maximum difference of the two slopes for which the long, less noisy line counts, in standard deviations."""
AMBIENT = 50
"""Number of readings before contact in the mean of the ambient temperature (0.5 s)."""


@dataclass(frozen=True, slots=True)
class RecordedTouch:
    """Start of a touch in a trace: index and time, s, of contact; reading, C; its slope, K/s; ambient, C, or None."""

    trace: ThermalTrace
    first: int
    contact_s: float
    start_c: float
    slope_k_s: float
    ambient_c: float | None

    def readings(self) -> Iterator[tuple[float, float, float]]:
        """Yield time since contact, s, plate, C, and force, N, of every sample from contact on."""
        trace = self.trace
        for k in range(self.first, len(trace.time_s)):
            yield float(trace.time_s[k]) - self.contact_s, float(trace.sensor_c[k]), float(trace.force_n[k])


def reading_at_contact(before_s: Sequence[float], before_c: Sequence[float]) -> tuple[float, float]:
    """Return the reading at contact, C, and its slope, K/s, from the newest readings of a free sensor.

    Raises ValueError without a reading.
    """
    if not before_c:
        raise ValueError("no reading before contact")
    if len(before_c) < SHORT:
        newest = before_c[-BEFORE:]
        return sum(newest) / len(newest), 0.0
    start_c, slope_k_s, slope_sd = _line(np.asarray(before_s[-SHORT:]), np.asarray(before_c[-SHORT:]))
    if len(before_c) >= WARMING:
        longer_c, longer_k_s, _ = _line(np.asarray(before_s[-WARMING:]), np.asarray(before_c[-WARMING:]))
        if abs(longer_k_s - slope_k_s) <= AGREE_SD * slope_sd:
            return longer_c, longer_k_s
    return start_c, slope_k_s


def _line(time_s: NDArray[np.float64], reading_c: NDArray[np.float64]) -> tuple[float, float, float]:
    """Fit a line to readings; return its end, C, its slope and the slope's standard deviation, K/s."""
    time_s = time_s - time_s.mean()
    spread = float(time_s @ time_s) or 1.0  # all times are equal where the sensor's clock stands still
    slope_k_s = float(time_s @ reading_c) / spread
    left = reading_c - reading_c.mean() - slope_k_s * time_s
    noise_k = float(np.sqrt(left @ left / (len(reading_c) - 2)))
    return float(reading_c.mean() + slope_k_s * time_s[-1]), slope_k_s, noise_k / spread**0.5


def _at_reading_rate(trace: ThermalTrace) -> ThermalTrace:
    """Return the trace, or means over READING_S of a much faster one: the model's noise is that of such a reading."""
    time_s = trace.time_s
    period = np.floor((time_s - time_s[0]) / READING_S + 1e-6)
    first = np.flatnonzero(np.diff(period, prepend=-1.0))
    if float(np.median(np.diff(time_s))) >= FASTER * READING_S or len(first) < 2:
        return trace
    count = np.diff(first, append=len(time_s))

    def means(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.add.reduceat(values, first) / count)

    return replace(
        trace,
        time_s=means(time_s),
        sensor_c=means(trace.sensor_c),
        force_n=means(trace.force_n),
        ambient_c=None if trace.ambient_c is None else means(trace.ambient_c),
        reference_c=None if trace.reference_c is None else means(trace.reference_c),
    )


def find_touch(trace: ThermalTrace) -> RecordedTouch | None:
    """Return the first contact of a trace; None without one.

    Without a measured ambient temperature, the unheated sensor before contact replaces it.
    """
    trace = _at_reading_rate(trace)
    first = trace.contact()
    if first is None:
        return None
    around = trace.ambient_c if trace.ambient_c is not None else trace.reference_c
    before = slice(max(first - WARMING, 0), max(first, 1))
    start_c, slope_k_s = reading_at_contact(trace.time_s[before].tolist(), trace.sensor_c[before].tolist())
    return RecordedTouch(
        trace=trace,
        first=first,
        contact_s=float(trace.time_s[first]),
        start_c=start_c,
        slope_k_s=slope_k_s,
        ambient_c=None if around is None else float(around[max(first - AMBIENT, 0) : max(first, 1)].mean()),
    )


def reference_touch(touch: RecordedTouch) -> RecordedTouch:
    """Return the same touch as measured by the unheated sensor beside the heated one.

    Raises:
        ValueError: the trace has no unheated sensor.
    """
    trace = touch.trace
    if trace.reference_c is None:
        raise ValueError(f"{trace.name}: column reference_c is missing")
    before = slice(max(touch.first - WARMING, 0), max(touch.first, 1))
    start_c, slope_k_s = reading_at_contact(trace.time_s[before].tolist(), trace.reference_c[before].tolist())
    return replace(touch, trace=replace(trace, sensor_c=trace.reference_c), start_c=start_c, slope_k_s=slope_k_s)
