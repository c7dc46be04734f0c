"""Waits longer after each failed try in a row. Pure: time is an argument, ns."""

from dataclasses import dataclass, field


@dataclass(slots=True)
class GrowingWait:
    """The wait before the next try; it doubles with each failure.

    Attributes:
        first_s: wait after the first failure, s.
        most_s: longest wait, s.
    """

    first_s: float
    most_s: float
    _failed: int = field(default=0, init=False)
    _until_ns: int | None = field(default=None, init=False)

    def fail(self, now_ns: int) -> float:
        """Note a failure; return the wait until the next try, s."""
        wait_s = min(self.most_s, self.first_s * 2.0 ** min(self._failed, 30))
        self._failed += 1
        self._until_ns = now_ns + round(wait_s * 1e9)
        return wait_s

    def over(self, now_ns: int) -> bool:
        """Return whether a try is allowed; a clock that was set back ends the wait."""
        if self._until_ns is not None and not 0 < self._until_ns - now_ns <= self.most_s * 1e9:
            self._until_ns = None
        return self._until_ns is None

    def reset(self) -> None:
        """Forget all failures."""
        self._failed, self._until_ns = 0, None
