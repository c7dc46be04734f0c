"""The newest samples of a few signals, for what is estimated from a short window of them."""

LEAST = 3
LONGEST_S = 0.1
"""An estimate needs so many samples at least; so far back they may lie when the loop was late, s."""
_ROUNDED_S = 1e-4


class RecentSamples:
    """Samples of the last `window_s`, and times in seconds as the first of the tracks."""

    __slots__ = ("_window_s", "tracks")

    def __init__(self, signals: int, window_s: float) -> None:
        self._window_s = window_s
        self.tracks: tuple[list[float], ...] = tuple([] for _ in range(1 + signals))

    def take(self, t_s: float, *values: float) -> bool:
        """Take what was sampled at `t_s`; a time that does not advance starts over. Returns whether it is enough."""
        times = self.tracks[0]
        if times and not t_s > times[-1]:
            for track in self.tracks:
                track.clear()
        for track, value in zip(self.tracks, (t_s, *values), strict=True):
            track.append(value)
        # A late tick must not leave the window empty: three samples say more than none, unless they are old.
        while t_s - times[0] > (self._window_s if len(times) > LEAST else LONGEST_S) + _ROUNDED_S:
            for track in self.tracks:
                del track[0]
        return len(times) >= LEAST
