"""Labelled touches in common arrays for the fit of populations."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.touch_start import READING_S

Array = NDArray[np.float64]

EACH_UNTIL = 60
"""Number of readings after contact that are used singly; later ones are averaged over BLOCK."""
BLOCK = 4
"""Number of late readings in one mean."""
KNOWN_OBJECT_SD_K = 0.03
"""Standard deviation of a measured object temperature, K."""
UNKNOWN_OBJECT_SD_K = 3.0
"""Initial standard deviation of an unknown object temperature around ambient, K."""


@dataclass(frozen=True, slots=True)
class CalibrationTouch:
    """One labelled touch, readings at 100 Hz from the first after contact.

    Attributes:
        material: index of its material.
        reading_c: (k,) readings, C.
        force_n: (k,) contact force, N.
        start_c: reading at contact, C.
        slope_k_s: slope of the reading just before contact, K/s.
        ambient_c: ambient temperature, C.
        object_c: temperature of the object, C.
        object_sd_k: standard deviation of the object's temperature, K.
    """

    material: int
    reading_c: Array
    force_n: Array
    start_c: float
    slope_k_s: float
    ambient_c: float
    object_c: float
    object_sd_k: float = KNOWN_OBJECT_SD_K


@dataclass(frozen=True, slots=True)
class CalibrationReadings:
    """All touches in arrays, cut to the shortest; temperatures are relative to each touch's reading at contact.

    Attributes:
        count: (k,) number of averaged readings; 1 for each of the first.
        material: (touches,) index of the material.
        reading_k: (touches, k) readings, K.
        force_n: (touches, k) contact force, N.
        slope_k_s: (touches,) slope of the reading just before contact, K/s.
        ambient_k: (touches,) ambient temperature, K.
        object_k: (touches,) temperature of the object, K.
        object_sd_k: (touches,) standard deviation of the object's temperature, K.
    """

    count: Array
    material: NDArray[np.intp]
    reading_k: Array
    force_n: Array
    slope_k_s: Array
    ambient_k: Array
    object_k: Array
    object_sd_k: Array

    @classmethod
    def of(cls, touches: Sequence[CalibrationTouch]) -> Self:
        """Make the arrays from all touches; their common length counts."""
        length = min(len(touch.reading_c) for touch in touches)
        edges = _edges(length)
        start = np.array([touch.start_c for touch in touches])
        return cls(
            count=np.diff(edges).astype(np.float64),
            material=np.array([touch.material for touch in touches]),
            reading_k=_means(np.stack([touch.reading_c[:length] for touch in touches]), edges) - start[:, None],
            force_n=_means(np.stack([touch.force_n[:length] for touch in touches]), edges),
            slope_k_s=np.array([touch.slope_k_s for touch in touches]),
            ambient_k=np.array([touch.ambient_c for touch in touches]) - start,
            object_k=np.array([touch.object_c for touch in touches]) - start,
            object_sd_k=np.array([touch.object_sd_k for touch in touches]),
        )

    @property
    def times_s(self) -> Array:
        """Times after contact at the middles of the averaged readings, s."""
        return np.asarray((np.cumsum(self.count) - 0.5 * (self.count - 1.0)) * READING_S)

    @property
    def steps(self) -> tuple[list[float], NDArray[np.intp], NDArray[np.intp]]:
        """Steps of a model that end at each of `times_s`, of few lengths: equal steps are computed in one block.

        Returns:
            Length of each step, s; index of the reading whose force acts in it; index of the step that ends at the
            middle of each reading.
        """
        single = int((self.count == 1.0).sum())
        late = len(self.count) - single
        readings = np.arange(len(self.count))
        # The first of two steps ends at the middle of a mean. The second ends half a reading into the next mean.
        steps_s = [READING_S] * single + [0.5 * READING_S] * min(late, 1) + [0.5 * BLOCK * READING_S] * (2 * late)
        of_step = np.concatenate((readings[:single], readings[single : single + 1], np.repeat(readings[single:], 2)))
        ends = np.concatenate((readings[:single], single + 1 + 2 * np.arange(late)))
        return steps_s, of_step, ends


def _edges(length: int) -> NDArray[np.intp]:
    """Return the first index of each block of readings, and the end of the last block."""
    late = np.arange(min(EACH_UNTIL, length), length + 1, BLOCK)
    return np.concatenate((np.arange(min(EACH_UNTIL, length)), late)).astype(np.intp)


def _means(values: Array, edges: NDArray[np.intp]) -> Array:
    """Return the means of (touches, readings) over blocks."""
    sums = np.concatenate((np.zeros((len(values), 1)), np.cumsum(values, axis=1)), axis=1)
    return np.asarray((sums[:, edges[1:]] - sums[:, edges[:-1]]) / np.diff(edges))
