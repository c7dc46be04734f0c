"""Assigns the slow work of each tick: fingers and the judgement of their hand take turns.

A tick solves one finger at most; a late tick solves none, unless that has waited for POSTPONED_S. Both follow from the
ticks' own times and from the readings, which a recording has: a replay solves when the session solved.
"""

import math
from collections.abc import Sequence
from typing import Protocol

LATE = 1.5
"""Largest distance of two ticks of which the second is not late, periods."""
POSTPONED_S = 0.2
"""Longest time that late ticks postpone a solution, s: a site that is always late solves five times a second."""
NOTHING_DUE = -math.inf
"""Waiting time where nothing is due, s."""


class Solver(Protocol):
    """A part of identification that takes its time."""

    @property
    def waited_s(self) -> float:
        """For how long it has been due, s; below 0 while it is not."""

    def work(self) -> None:
        """Do what is due."""


class SolvingTurns:
    """Gives each tick to one of those that are due, one after the other. Pure: times, s, in.

    Attributes:
        postponed: ticks so far in which all that was due waited, since the tick was late.
    """

    def __init__(self, period_s: float) -> None:
        """Take the time from one tick to the next, s; if it is infinite no tick is late."""
        self._longest_s = LATE * period_s
        self._before_s = math.inf
        self._first = 0
        self.postponed = 0

    def step(self, t_s: float, solvers: Sequence[Solver]) -> Solver | None:
        """Whose turn the tick is that begins at `t_s`; None where it is nobody's.

        Args:
            t_s: time, s.
            solvers: all that take turns, the same in each tick.
        """
        late = t_s - self._before_s > self._longest_s
        self._before_s = t_s
        least_s = POSTPONED_S if late else 0.0
        waits = False
        for number in range(self._first, self._first + len(solvers)):
            solver = solvers[number % len(solvers)]
            if solver.waited_s >= least_s:
                self._first = (number + 1) % len(solvers)
                return solver
            waits = waits or solver.waited_s >= 0.0
        self.postponed += waits
        return None
