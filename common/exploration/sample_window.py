"""A window of the newest samples of a few signals, for estimators."""

from collections import deque

LEAST = 3
"""Minimum number of samples for an estimate."""
LONGEST_S = 0.1
"""Maximum age of the oldest of LEAST samples that a late loop left, s."""
ROUNDED_S = 1e-4
OLD_S = LONGEST_S + ROUNDED_S


class SampleWindow:
    """Samples of the last `window_s`, s, at most LONGEST_S, each with its time first."""

    def __init__(self, window_s: float) -> None:
        self._window_s = window_s + ROUNDED_S
        self._samples: deque[tuple[float, ...]] = deque()

    def take(self, *sample: float) -> None:
        """Take a sample: its time, s, and then its values; a time that does not advance clears the window."""
        samples, t_s = self._samples, sample[0]
        if samples and not t_s > samples[-1][0]:
            samples.clear()
        samples.append(sample)
        # After a late tick the window keeps LEAST samples, unless they are too old.
        while (age_s := t_s - samples[0][0]) > self._window_s and (len(samples) > LEAST or age_s > OLD_S):
            samples.popleft()

    @property
    def enough(self) -> bool:
        """Whether there are at least LEAST samples."""
        return len(self._samples) >= LEAST

    @property
    def tracks(self) -> list[tuple[float, ...]]:
        """Times, s, and then each signal, oldest first; there must be at least one sample."""
        return list(zip(*self._samples, strict=True))

    def rise(self) -> list[float]:
        """Return the growth of time and of each signal from the first to the last third of the window.

        Each is a difference of sums: divide one by another for a rate.
        """
        samples = list(self._samples)
        third = len(samples) // 3
        late, early = zip(*samples[-third:], strict=True), zip(*samples[:third], strict=True)
        return [sum(last) - sum(first) for last, first in zip(late, early, strict=True)]
