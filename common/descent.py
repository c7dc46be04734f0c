"""How fast a fingertip comes down just now, from noisy, quantised heights."""

from common.recent_samples import RecentSamples

WINDOW_S = 0.016


class Descent:
    """Speed of one fingertip towards the bench.

    It is the slope, at the newest sample, of the parabola through the means of the window's thirds: a finger may slow
    down by half within the window.
    """

    __slots__ = ("_enough", "_recent")

    def __init__(self) -> None:
        self._recent = RecentSamples(1, WINDOW_S)
        self._enough = False

    def step(self, t_s: float, z_m: float) -> None:
        """Take the height at `t_s`; a time that does not advance starts over."""
        self._enough = self._recent.take(t_s, z_m)

    @property
    def speed_m_s(self) -> float:
        """Downwards, m/s; negative upwards."""
        if not self._enough:
            return 0.0
        (first_s, middle_s, last_s), (first_m, middle_m, last_m) = map(_thirds, self._recent.tracks)
        early_m_s = (first_m - middle_m) / (middle_s - first_s)
        late_m_s = (middle_m - last_m) / (last_s - middle_s)
        change_m_s2 = 2.0 * (late_m_s - early_m_s) / (last_s - first_s)
        return late_m_s + change_m_s2 * (self._recent.tracks[0][-1] - 0.5 * (middle_s + last_s))


def _thirds(track: list[float]) -> tuple[float, float, float]:
    """Means of the first, middle and last part."""
    third = len(track) // 3
    middle = track[third:-third]
    return sum(track[:third]) / third, sum(middle) / len(middle), sum(track[-third:]) / third
