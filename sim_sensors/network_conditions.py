"""What a network is like at a time: how long it takes, how much it loses, how much it carries."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

SHORTEST_RETRANSMISSION_S = 0.2
"""TCP waits at least this long before it sends a lost segment again."""
_MARGIN_S = 0.05


@dataclass(frozen=True, slots=True)
class Conditions:
    """The state of one direction of a network.

    Attributes:
        delay_s: one way.
        jitter_s: by how much the delay varies to either side; at most the delay itself.
        loss: share of TCP segments that do not arrive at the first try, 0 to 1.
        rate_bit_s: what all connections together may carry.
    """

    delay_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    rate_bit_s: float = math.inf

    @property
    def retransmission_s(self) -> float:
        """How long TCP waits for an acknowledgement before it sends a segment again."""
        return max(SHORTEST_RETRANSMISSION_S, 2.0 * (self.delay_s + self.jitter_s) + _MARGIN_S)


class ConditionsOverTime(Protocol):
    """How a network changes."""

    def at(self, time_s: float) -> Conditions:
        """What it is like at `time_s` >= 0."""


class PhasedConditions:
    """Constant from the start of one phase to the start of the next; the last one stays."""

    def __init__(self, starts_s: Sequence[float], phases: Sequence[Conditions]) -> None:
        """Take phases in order of time; the first starts at 0."""
        self._starts_s = list(starts_s)
        self._phases = list(phases)

    def at(self, time_s: float) -> Conditions:
        """What it is like at `time_s` >= 0."""
        return self._phases[max(0, bisect_right(self._starts_s, time_s) - 1)]


class RecordedConditions:
    """Half of recorded round trips in each direction, linear in between, over and over again."""

    def __init__(self, send_time_s: Sequence[float], round_trip_s: Sequence[float]) -> None:
        """Take times of sending, which increase, and the round trip that began at each."""
        self._time_s = np.array(send_time_s) - send_time_s[0]
        self._delay_s = 0.5 * np.array(round_trip_s)

    def at(self, time_s: float) -> Conditions:
        """What it is like at `time_s` >= 0."""
        return Conditions(delay_s=float(np.interp(time_s % self._time_s[-1], self._time_s, self._delay_s)))
