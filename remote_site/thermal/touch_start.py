"""A recorded touch as the online identification meets it: start, ambient, readings in contact."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from remote_site.traces.trace_files import ThermalTrace

READING_S = 0.01
"""Period of the thermal sensor's readings, s."""
BEFORE = 5
"""Readings averaged into one value of the plate before contact, where there are too few to see a slope (50 ms)."""
SHORT, WARMING = 25, 50
"""Readings before contact whose straight line tells how warm the plate was and how fast it warmed (0.25 and 0.5 s)."""
AGREE_SD = 2.0
"""The longer line is less noisy; it counts where the shorter one, known to this many deviations, has the same slope."""
AMBIENT = 50
"""Readings before contact averaged into the ambient temperature (0.5 s)."""


@dataclass(frozen=True, slots=True)
class RecordedTouch:
    """Start of a touch in a trace: index and time of contact, reading and its slope then, ambient where known."""

    trace: ThermalTrace
    first: int
    contact_s: float
    start_c: float
    slope_k_s: float
    ambient_c: float | None

    def readings(self) -> Iterator[tuple[float, float, float]]:
        """Time since contact, s, plate, C, and force, N, of every sample from contact on."""
        trace = self.trace
        for k in range(self.first, len(trace.time_s)):
            yield float(trace.time_s[k]) - self.contact_s, float(trace.sensor_c[k]), float(trace.force_n[k])


def reading_at_contact(before_c: Sequence[float]) -> tuple[float, float]:
    """Reading at contact, C, and its slope, K/s, from the newest readings of a free sensor, oldest first.

    Raises:
        ValueError: there is no reading.
    """
    if not before_c:
        raise ValueError("no reading before contact")
    if len(before_c) < SHORT:
        newest = before_c[-BEFORE:]
        return sum(newest) / len(newest), 0.0
    start_c, slope_k_s, slope_sd = _line(np.asarray(before_c[-SHORT:]))
    if len(before_c) >= WARMING:
        longer_c, longer_k_s, _ = _line(np.asarray(before_c[-WARMING:]))
        if abs(longer_k_s - slope_k_s) <= AGREE_SD * slope_sd:
            return longer_c, longer_k_s
    return start_c, slope_k_s


def _line(reading_c: NDArray[np.float64]) -> tuple[float, float, float]:
    """The straight line through readings: its end, C, its slope and how well that is known, K/s."""
    time_s = READING_S * np.arange(len(reading_c))
    time_s -= time_s.mean()
    spread = float(time_s @ time_s)
    slope_k_s = float(time_s @ reading_c) / spread
    left = reading_c - reading_c.mean() - slope_k_s * time_s
    noise_k = float(np.sqrt(left @ left / (len(reading_c) - 2)))
    return float(reading_c.mean() + slope_k_s * time_s[-1]), slope_k_s, noise_k / spread**0.5


def find_touch(trace: ThermalTrace) -> RecordedTouch | None:
    """The first contact of a trace; None where there is none.

    Where nothing measures the ambient temperature, an unheated sensor before contact stands in.
    """
    first = trace.contact()
    if first is None:
        return None
    around = trace.ambient_c if trace.ambient_c is not None else trace.reference_c
    start_c, slope_k_s = reading_at_contact(trace.sensor_c[max(first - WARMING, 0) : max(first, 1)].tolist())
    return RecordedTouch(
        trace=trace,
        first=first,
        contact_s=float(trace.time_s[first]),
        start_c=start_c,
        slope_k_s=slope_k_s,
        ambient_c=None if around is None else float(around[max(first - AMBIENT, 0) : max(first, 1)].mean()),
    )


def reference_touch(touch: RecordedTouch) -> RecordedTouch:
    """The same touch as the unheated sensor beside the heated one met it.

    Raises:
        ValueError: the trace has no unheated sensor.
    """
    trace = touch.trace
    if trace.reference_c is None:
        raise ValueError(f"{trace.name}: column reference_c is missing")
    before = trace.reference_c[max(touch.first - WARMING, 0) : max(touch.first, 1)].tolist()
    start_c, slope_k_s = reading_at_contact(before)
    return replace(touch, trace=replace(trace, sensor_c=trace.reference_c), start_c=start_c, slope_k_s=slope_k_s)
