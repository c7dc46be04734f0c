"""A recorded touch as the online identification meets it: start, ambient, readings in contact."""

from collections.abc import Iterator
from dataclasses import dataclass

from remote_site.traces import ThermalTrace

BEFORE = 5
"""Readings before contact averaged into the plate's start temperature (50 ms)."""
AMBIENT = 50
"""Readings before contact averaged into the ambient temperature (0.5 s)."""


@dataclass(frozen=True, slots=True)
class RecordedTouch:
    """Start of a touch in a trace: index and time of contact, plate then, ambient where known."""

    trace: ThermalTrace
    first: int
    contact_s: float
    start_c: float
    ambient_c: float | None

    def readings(self) -> Iterator[tuple[float, float, float]]:
        """Time since contact, s, plate, C, and force, N, of every sample from contact on."""
        trace = self.trace
        for k in range(self.first, len(trace.time_s)):
            yield float(trace.time_s[k]) - self.contact_s, float(trace.sensor_c[k]), float(trace.force_n[k])


def find_touch(trace: ThermalTrace) -> RecordedTouch | None:
    """The first contact of a trace; None where there is none.

    Where nothing measures the ambient temperature, an unheated sensor before contact stands in.
    """
    first = trace.contact()
    if first is None:
        return None
    around = trace.ambient_c if trace.ambient_c is not None else trace.reference_c
    return RecordedTouch(
        trace=trace,
        first=first,
        contact_s=float(trace.time_s[first]),
        start_c=float(trace.sensor_c[max(first - BEFORE, 0) : max(first, 1)].mean()),
        ambient_c=None if around is None else float(around[max(first - AMBIENT, 0) : max(first, 1)].mean()),
    )
