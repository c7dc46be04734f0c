"""Measures the processor time of each stage of a site's tick; a stage is a step named by the site's containment."""

import time
from collections.abc import Callable
from types import TracebackType

from common.faults.fault import Fault
from common.runtime.containment import Containment, Step


class StageClock(Containment):
    """Containment of the product that also sums the thread's processor time of each outermost step, ns."""

    def __init__(self, latch: Callable[[Fault], None] = lambda fault: None):
        """Start with no time spent."""
        super().__init__(latch)
        self._spent_ns: dict[str, int] = {}
        self._within = False

    def step(self, name: str, *, latches: bool = True, passes: tuple[type[Exception], ...] = ()) -> Step:
        """Return a step as `Containment.step` does; an outermost step is timed."""
        if self._within:
            return super().step(name, latches=latches, passes=passes)
        return _TimedStep(self, name, latches, passes)

    def take_spent_ns(self) -> dict[str, int]:
        """Return the time that each stage has spent since the last call, ns."""
        spent, self._spent_ns = self._spent_ns, {}
        return spent

    def begin(self) -> None:
        """Begin an outermost step."""
        self._within = True

    def end(self, name: str, spent_ns: int) -> None:
        """End the outermost step, and add its processor time, ns."""
        self._within = False
        self._spent_ns[name] = self._spent_ns.get(name, 0) + spent_ns


class _TimedStep(Step):
    def __init__(self, clock: StageClock, name: str, latches: bool, passes: tuple[type[Exception], ...]):
        super().__init__(clock, name, latches, passes)
        self._clock, self._stage = clock, name

    def __enter__(self) -> None:
        self._clock.begin()
        self._begun_ns = time.thread_time_ns()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        self._clock.end(self._stage, time.thread_time_ns() - self._begun_ns)
        return super().__exit__(kind, error, trace)
