"""How fast a fingertip comes down, from noisy, quantised heights at uneven times."""

from common.exploration.sample_window import SampleWindow

WINDOW_S = 0.012
"""Long enough for readings that come up to 2 ms early or late, short enough for a finger that slows down."""


class ApproachSpeed:
    """Speed of one fingertip towards the bench: from the mean heights in the first and the last third of the window."""

    __slots__ = ("_recent",)

    def __init__(self) -> None:
        self._recent = SampleWindow(WINDOW_S)

    def step(self, t_s: float, z_m: float) -> None:
        """Take the height at `t_s`; a time that does not advance starts over."""
        self._recent.take(t_s, z_m)

    @property
    def speed_m_s(self) -> float:
        """Mean over the window, m/s; negative upwards."""
        if not self._recent.enough:
            return 0.0
        passed_s, risen_m = self._recent.rise()
        return -risen_m / passed_s
