"""The newest samples of a few signals, for what is estimated from a short window of them."""

from collections import deque

LEAST = 3
LONGEST_S = 0.1
"""An estimate needs so many samples at least; so far back they may lie when the loop was late, s."""
ROUNDED_S = 1e-4
OLD_S = LONGEST_S + ROUNDED_S


class SampleWindow:
    """Samples of the last `window_s`, LONGEST_S at most, each with its time first."""

    __slots__ = ("_samples", "_window_s")

    def __init__(self, window_s: float) -> None:
        self._window_s = window_s + ROUNDED_S
        self._samples: deque[tuple[float, ...]] = deque()

    def take(self, *sample: float) -> None:
        """Take what was sampled at a time, s, which comes first; a time that does not advance starts over."""
        samples, t_s = self._samples, sample[0]
        if samples and not t_s > samples[-1][0]:
            samples.clear()
        samples.append(sample)
        # A late tick must not leave the window empty: three samples say more than none, unless they are old.
        while (age_s := t_s - samples[0][0]) > self._window_s and (len(samples) > LEAST or age_s > OLD_S):
            samples.popleft()

    @property
    def enough(self) -> bool:
        """Whether there are LEAST samples."""
        return len(self._samples) >= LEAST

    @property
    def tracks(self) -> list[tuple[float, ...]]:
        """Times, s, then each signal, oldest first; there must be a sample."""
        return list(zip(*self._samples, strict=True))

    def rise(self) -> list[float]:
        """By how much time and each signal grow from the first third of the window to the last, summed over a third."""
        samples = list(self._samples)
        third = len(samples) // 3
        late, early = zip(*samples[-third:], strict=True), zip(*samples[:third], strict=True)
        return [sum(last) - sum(first) for last, first in zip(late, early, strict=True)]
