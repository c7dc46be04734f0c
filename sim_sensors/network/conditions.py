"""Network conditions as a function of time: delay, jitter, loss and rate."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

SHORTEST_RETRANSMISSION_S = 0.2
"""Shortest time before TCP retransmits a lost segment, s."""
_MARGIN_S = 0.05


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
        """Time that TCP waits for an acknowledgement before it retransmits a segment, s."""
        return max(SHORTEST_RETRANSMISSION_S, 2.0 * (self.delay_s + self.jitter_s) + _MARGIN_S)


class ConditionsOverTime(Protocol):
    """Network conditions that may change with time."""

    def at(self, time_s: float) -> Conditions:
        """Return the conditions at `time_s` >= 0."""


class PhasedConditions:
    """Conditions that are constant within each phase; the last phase never ends."""

    def __init__(self, starts_s: Sequence[float], phases: Sequence[Conditions]) -> None:
        """Take phases in order of time; the first starts at 0."""
        self._starts_s = list(starts_s)
        self._phases = list(phases)

    def at(self, time_s: float) -> Conditions:
        """Return the conditions at `time_s` >= 0."""
        return self._phases[max(0, bisect_right(self._starts_s, time_s) - 1)]


class RecordedConditions:
    """Half of the recorded round trips as delay in each direction, linear in between; the record repeats endlessly."""

    def __init__(self, send_time_s: Sequence[float], round_trip_s: Sequence[float]) -> None:
        """Take increasing times of sending, s, and the round trip that began at each, s."""
        self._time_s = np.array(send_time_s) - send_time_s[0]
        self._delay_s = 0.5 * np.array(round_trip_s)

    def at(self, time_s: float) -> Conditions:
        """Return the conditions at `time_s` >= 0."""
        return Conditions(delay_s=float(np.interp(time_s % self._time_s[-1], self._time_s, self._delay_s)))
