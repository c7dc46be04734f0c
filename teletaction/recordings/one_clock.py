"""Puts the recordings of two hosts on one clock, by the offsets that the operator site measured during the session."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from operator_site.recorded_rows import Clock

LEAST_INSIDE = 0.95
"""Smallest share of the measured offsets whose bounds must contain the fitted line."""


class TwoClocks(ValueError):
    """Recordings whose times cannot be put on one clock. The message gives the reason."""


@dataclass(frozen=True, slots=True)
class ClockLine:
    """Offset of the remote host's monotonic clock from the operator's: a straight line, for two quartz clocks.

    Attributes:
        start_ns: operator's time at which the line begins, ns.
        offset_ns: remote minus operator there, ns.
        drift: change of the offset, s/s.
        uncertainty_p95_ns: bound of the line's error, ns; 95 % of the measured bounds are at most this far from it.
    """

    start_ns: int
    offset_ns: int
    drift: float
    uncertainty_p95_ns: int

    @classmethod
    def fit(cls, measured: Iterable[tuple[int, Clock]]) -> Self:
        """Fit the line to offsets and their operator's times, ns.

        Raises:
            TwoClocks: no offset was measured, or a clock was stepped or stood still during the session.
        """
        known = [
            (time_ns, each.offset_ns, each.uncertainty_ns)
            for time_ns, each in measured
            if each.uncertainty_ns is not None
        ]
        if not known:
            raise TwoClocks("no offset between the clocks of the two hosts was measured")
        start_ns, first_ns = known[0][0], known[0][1]
        # Differences of whole numbers first: a float has no nanoseconds of a clock that ran for a day.
        t_s = np.array([(time_ns - start_ns) * 1e-9 for time_ns, _, _ in known])
        offset_ns = np.array([float(offset - first_ns) for _, offset, _ in known])
        bound_ns = np.array([float(bound) for _, _, bound in known])
        slope, level = _line(t_s, offset_ns, 1.0 / np.maximum(bound_ns, 1.0))
        error_ns = np.abs(level + slope * t_s - offset_ns)
        inside = float(np.mean(error_ns <= bound_ns + 1.0))
        if inside < LEAST_INSIDE:
            raise TwoClocks(
                f"one clock was stepped or stood still: a line fits only {inside:.0%} of {len(known)} measured offsets"
            )
        worst_ns = float(np.percentile(error_ns + bound_ns, 95))
        return cls(start_ns, first_ns + round(level), slope * 1e-9, round(worst_ns))

    def operator_time_ns(self, remote_ns: int) -> int:
        """Convert a time of the remote host's clock to the operator's, ns."""
        lead_ns = remote_ns - self.start_ns - self.offset_ns
        return self.start_ns + lead_ns - round(self.drift / (1.0 + self.drift) * lead_ns)


def _line(t_s: NDArray[np.float64], values: NDArray[np.float64], weights: NDArray[np.float64]) -> tuple[float, float]:
    """Slope and level of a weighted straight line; a slope of 0 where there is one time only."""
    if np.ptp(t_s) == 0.0:
        return 0.0, float(np.average(values, weights=weights))
    slope, level = np.polyfit(t_s, values, 1, w=weights)
    return float(slope), float(level)


def require_one_host(names: Sequence[str], line: ClockLine) -> None:
    """Check recordings that do not name their hosts: of one host, the offset is zero.

    Raises:
        TwoClocks: the clocks differ, so there were two hosts.
    """
    if abs(line.offset_ns) > line.uncertainty_p95_ns:
        raise TwoClocks(
            f"{', '.join(names)}: recorded on two hosts whose clocks differ by {line.offset_ns * 1e-9:+.3f} s; "
            "version 0.1.0 did not record on which: use each by itself"
        )
