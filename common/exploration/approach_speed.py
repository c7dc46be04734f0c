"""Estimates the approach speed of a fingertip from noisy, quantised heights at uneven times."""

from common.exploration.sample_window import SampleWindow

WINDOW_S = 0.012
"""Length of the window, s: it covers readings up to 2 ms early or late, and still follows a finger that slows down."""


class ApproachSpeed:
    """Approach speed of one fingertip, from the mean heights in the first and the last third of the window."""

    def __init__(self) -> None:
        self._recent = SampleWindow(WINDOW_S)

    def step(self, t_s: float, z_m: float) -> None:
        """Take the height at `t_s`, s and m; a time that does not advance clears the window."""
        self._recent.take(t_s, z_m)

    @property
    def speed_m_s(self) -> float:
        """Mean approach speed over the window, m/s; negative upwards."""
        if not self._recent.enough:
            return 0.0
        passed_s, risen_m = self._recent.rise()
        return -risen_m / passed_s
