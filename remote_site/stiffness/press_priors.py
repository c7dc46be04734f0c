"""Priors of the force law: the general one, and others that the samples of presses hardly exclude.

A few samples do not show whether the force grows with a power of the depth or exponentially. Nor do they show whether
the force at the first sample is the sensor's offset, or a touch that began above it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

OFFSET_SD_N, CONTACT_SD_MM = 0.03, 0.03
"""Standard deviations of the force sensor's offset, N, and of a robot's contact about the first sample, mm."""
NO_OFFSET_SD_N, TOUCH_SD_MM = 0.003, 0.15
"""The same standard deviations where the force at the first sample is a touch that began above it."""


@dataclass(frozen=True, slots=True)
class Prior:
    """Normal distribution of the parameters of `force_law` over objects and places.

    Attributes:
        mean: mean of the parameters, (5,); a is relative to that of a typical press of the object.
        sd: standard deviation of the parameters, (5,); that of the contact is `contact_sd_mm`.
        contact_sd_mm: standard deviation of the contact about the first sample, mm.
    """

    mean: Array
    sd: Array
    contact_sd_mm: float


def _prior(power: tuple[float, float], stiffening: tuple[float, float], offset_sd_n: float, contact_mm: float) -> Prior:
    """Return the prior with mean and standard deviation of ln(p - 1), and those of ln g."""
    mean, sd = np.array([(0.0, 1.0), power, stiffening, (0.0, 0.0), (0.0, offset_sd_n)]).T
    return Prior(mean, sd, contact_mm)


_ANY_LAW = (-1.5, 0.8), (-1.0, 0.9)
_POWER_LAW = (-0.7, 1.2), (-4.0, 0.5)
_SPRING = (-6.0, 0.5), (-6.0, 0.5)
GENERAL = _prior(*_ANY_LAW, OFFSET_SD_N, CONTACT_SD_MM)
"""Prior of silicone and tissue."""
OTHER_LAWS = tuple(_prior(*law, OFFSET_SD_N, CONTACT_SD_MM) for law in (_POWER_LAW, _SPRING))
"""Priors of other laws: a power of the depth alone, and a spring."""
OTHER_CONTACTS = tuple(_prior(*law, NO_OFFSET_SD_N, TOUCH_SD_MM) for law in (_ANY_LAW, _POWER_LAW))
"""Priors of a touch that began elsewhere than at the first sample."""
CONTACT_ODDS = (1 + len(OTHER_LAWS)) / len(OTHER_CONTACTS)
"""Odds of one of OTHER_CONTACTS against the general prior: a contact elsewhere is as likely as at the first sample."""
