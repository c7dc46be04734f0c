"""Thermal dose of skin under one plate, a fingertip's or a patient's.

The dose is the integral of max(0, T - 40 C) over the last minute. Between two readings the plate counts as hot as the
hotter of them, for any time between. A standstill of the site or a lost reading thus counts with its true time.
"""

from collections import deque

from common.limits import DOSE_ABOVE_C, DOSE_LIMIT_K_S, DOSE_WINDOW_S

BIN_S = 1.0
"""Width of a bin, s. A bin is dropped when all of it is older than the window, so no dose is dropped too early."""
COAST_S = 2.0
"""Time for which a plate continues to heat skin after its drive is off, s; this dose is counted in advance."""
RESUME_SHARE = 0.5
"""Share of the limit below which a spent dose permits driving again; the hysteresis prevents chatter."""


class ThermalDose:
    """Adds up the dose; `step` returns when the drive must be off."""

    def __init__(self) -> None:
        self._bins: deque[list[float]] = deque()
        self._total = 0.0
        self._spent = False
        self._read_s: float | None = None
        self._over_k = 0.0

    def step(self, t_s: float, plate_c: float) -> bool:
        """Add the dose of a finite reading, C; return whether it is spent. A clock that was set back adds none."""
        if plate_c <= DOSE_ABOVE_C and not self._bins:  # the usual case; a hotter reading leaves a bin
            self._read_s, self._spent = t_s, False
            return False
        dt_s = 0.0 if self._read_s is None else min(DOSE_WINDOW_S, max(0.0, t_s - self._read_s))
        self._read_s = t_s
        bins = self._bins
        while bins and t_s - bins[0][0] > DOSE_WINDOW_S + BIN_S:
            bins.popleft()
            self._total = sum(dose for _, dose in bins)
        before_k, self._over_k = self._over_k, max(0.0, plate_c - DOSE_ABOVE_C)
        over_k = max(before_k, self._over_k)
        if over_k > 0.0:
            if not bins or t_s - bins[-1][0] >= BIN_S:
                bins.append([t_s, 0.0])
            bins[-1][1] += over_k * dt_s
            self._total += over_k * dt_s
        share = RESUME_SHARE if self._spent else 1.0
        self._spent = self._total + self._over_k * COAST_S >= share * DOSE_LIMIT_K_S
        return self._spent
