"""Times periodic work, each task at its own interval."""


class Interval:
    """Reports when periodic work is due. Pure: time is an argument, s; a clock that was set back makes it due."""

    def __init__(self, every_s: float):
        self._every_s, self._at_s = every_s, -float("inf")

    def __call__(self, now_s: float, every_s: float | None = None) -> bool:
        """Return whether the work is due at `now_s`; a due call begins the next interval, of `every_s` if given, s."""
        if 0.0 <= now_s - self._at_s < (self._every_s if every_s is None else every_s):
            return False
        self._at_s = now_s
        return True
