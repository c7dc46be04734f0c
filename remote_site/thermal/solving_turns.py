"""Assigns the slow work of each tick: fingers and the judgement of their hand take turns.

A tick solves at most one finger. A late tick solves none, unless one has waited for POSTPONED_S. Both rules depend only
on the times of ticks and on readings, which a recording contains. A replay therefore solves when the session solved.
"""

import math
from collections.abc import Sequence
from typing import Protocol

LATE = 1.5
"""Interval between two ticks above which the second is late, periods."""
POSTPONED_S = 0.2
"""Longest time for which late ticks postpone a solution, s; a site that is always late solves five times a second."""
NOTHING_DUE = -math.inf
"""Waiting time if nothing is due, s."""


class Solver(Protocol):
    """A slow part of the identification."""

    @property
    def waited_s(self) -> float:
        """Time since the work became due, s; negative if none is due."""

    def work(self) -> None:
        """Do the due work."""


class SolvingTurns:
    """Gives each tick to one solver with due work, in turn. Pure: times are arguments, s.

    Attributes:
        postponed: number of ticks in which all due work waited because the tick was late.
    """

    def __init__(self, period_s: float) -> None:
        """Take the time from one tick to the next, s; if it is infinite no tick is late."""
        self._longest_s = LATE * period_s
        self._before_s = math.inf
        self._first = 0
        self.postponed = 0

    def step(self, t_s: float, solvers: Sequence[Solver]) -> Solver | None:
        """Return the solver for the tick that begins at `t_s`; None without one. All solvers are the same each tick."""
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
