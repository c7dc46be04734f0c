"""Network conditions as a function of time: delay, jitter, loss and rate."""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

TIMEOUT_MARGIN_S = 0.2
"""Time-out of TCP beyond a round trip, s; Linux has 200 ms (`tcp_rto_min_us`)."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """Conditions of one direction of a network.

    Attributes:
        delay_s: one-way delay.
        jitter_s: variation of the delay to either side; at most the delay itself.
        loss: share of TCP segments lost at the first try, 0 to 1.
        rate_bit_s: rate limit of all connections together.
    """

    delay_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    rate_bit_s: float = math.inf

    @property
    def retransmission_s(self) -> float:
        """Time-out for the acknowledgement of a segment, s."""
        return 2.0 * (self.delay_s + self.jitter_s) + TIMEOUT_MARGIN_S


ConditionsOverTime = Callable[[float], Conditions]
"""Network conditions as a function of time >= 0, s."""


def phased(starts_s: Sequence[float], phases: Sequence[Conditions]) -> ConditionsOverTime:
    """Return conditions that are constant within each phase; the first starts at 0, and the last never ends."""
    return lambda time_s: phases[max(0, bisect_right(starts_s, time_s) - 1)]


def recorded(send_time_s: Sequence[float], round_trip_s: Sequence[float]) -> ConditionsOverTime:
    """Return half of the recorded round trips as delay in each direction, linear in between; the record repeats.

    The times of sending increase, s.
    """
    times_s, delays_s = np.array(send_time_s) - send_time_s[0], 0.5 * np.array(round_trip_s)
    return lambda time_s: Conditions(delay_s=float(np.interp(time_s % times_s[-1], times_s, delays_s)))
