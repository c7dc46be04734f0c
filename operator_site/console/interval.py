"""What is done again and again, each at its own pace."""


class Interval:
    """Says when something is due again. Pure: time is an argument, s; a clock that was set back makes it due."""

    def __init__(self, every_s: float):
        self._every_s, self._at_s = every_s, -float("inf")

    def __call__(self, now_s: float, every_s: float | None = None) -> bool:
        """Whether it is due now, and done by that."""
        if 0.0 <= now_s - self._at_s < (self._every_s if every_s is None else every_s):
            return False
        self._at_s = now_s
        return True
