"""Keeps samples of a press, so that a line through its forces can be shown no harder than the tissue at any depth."""

from typing import NamedTuple

STEP, MOST = 0.25, 32
"""Change of force between kept samples, as a fraction of the force, and maximum number of kept samples."""
MOVES_M = 30e-6
"""Smallest motion of a pressing or leaving finger that counts, m: three times the noise of its height."""


class PressedSample(NamedTuple):
    """Mean of some samples of a press: force, N, height, m, speed downwards, m/s, and number of samples."""

    force_n: float
    z_m: float
    speed_m_s: float
    samples: int


class PressedSamples:
    """Samples of one press, from the first contact to the largest force.

    Attributes:
        kept: the samples, at the height that the surface had at contact.
        followed_m: motion of the surface since contact, m.
    """

    def __init__(self, z_m: float) -> None:
        """Begin a press at a height, m."""
        self.kept: list[PressedSample] = []
        self._z_m, self.followed_m = z_m, 0.0

    def take(self, sample: PressedSample) -> bool:
        """Take a sample; return whether the finger has moved since the last one for which this was True."""
        moves_m, kept = sample.z_m - self._z_m, self.kept
        if abs(moves_m) <= MOVES_M:
            return False
        self._z_m = sample.z_m
        differs = not kept or abs(sample.force_n - kept[-1].force_n) > STEP * kept[-1].force_n
        if moves_m < 0.0 and differs and len(kept) < MOST:
            kept.append(sample._replace(z_m=sample.z_m - self.followed_m))
        return True

    def follow(self, moved_m: float) -> None:
        """Move all samples with the surface, m."""
        self.followed_m += moved_m

    def forget(self) -> None:
        """Forget all samples: they belong to another surface."""
        self.kept.clear()
