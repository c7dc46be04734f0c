"""Corrects the evidence of touches by the discrepancy of their sensor."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.discrepancy import Discrepancy
from remote_site.thermal.touch_estimate import TouchEvidence

Array = NDArray[np.float64]

BEYOND = 0.04
"""Standard deviation of the error per kelvin that an object is colder or warmer than all objects of calibration."""


class EvidenceCorrection:
    """Correction for one table; it has no state of a touch."""

    def __init__(self, discrepancy: Discrepancy, ln_effusivity: Array) -> None:
        """Prepare for substances.

        Args:
            discrepancy: discrepancy of the sensor, with c materials.
            ln_effusivity: (m,) ln effusivity of each substance, calibrated ones first. The others get the errors of
                calibrated materials with similar effusivity.
        """
        known = len(discrepancy.by_plate[0])
        order = np.argsort(ln_effusivity[:known])
        at = ln_effusivity[:known][order]

        def for_all(rows: list[list[float]]) -> Array:
            return np.array([[*row, *np.interp(ln_effusivity[known:], at, np.array(row)[order])] for row in rows])

        self._times_s = np.array(discrepancy.times_s)
        self._plate_k, self._coldest_k, self._warmest_k = for_all(
            [discrepancy.plate_k, discrepancy.coldest_k, discrepancy.warmest_k]
        )
        self._by_plate, self._by_object = for_all(discrepancy.by_plate), for_all(discrepancy.by_object)
        self._by_object_sd = for_all(discrepancy.by_object_sd)
        spread, unknown = np.array(discrepancy.spread), ~np.array(discrepancy.known_objects)
        self._spread, self._common = for_all((spread * ~unknown).tolist()), for_all((spread * unknown).tolist())
        self._stated_sd, self._sharpness = np.array(discrepancy.stated_sd), np.array(discrepancy.sharpness)

    def corrected(self, touch: TouchEvidence, since_s: float) -> TouchEvidence:
        """Return the evidence with the discrepancy taken out of the means and put into the covariances.

        A plate that is warmer or colder than in calibration shows another error. It may keep its size or grow with the
        plate's temperature, so that the difference between both counts as uncertain. Where calibration did not know the
        temperatures of the objects, the spread is an error of the material, which all touches have in common. So is the
        error of an object unlike those of calibration.

        Args:
            touch: evidence.
            since_s: time after contact, s.
        """
        before = max(int(np.searchsorted(self._times_s, since_s)) - 1, 0)
        after = min(before + 1, len(self._times_s) - 1)
        length_s = self._times_s[after] - self._times_s[before]
        part = min(max((since_s - self._times_s[before]) / length_s, 0.0), 1.0) if length_s > 0.0 else 0.0

        def now(values: Array) -> Array:
            return np.asarray((1.0 - part) * values[before] + part * values[after])

        by_plate, scale = now(self._by_plate), 1.0 / (1.0 + now(self._by_object))
        stated = now(self._stated_sd) * scale
        plate_k = touch.start_c - touch.ambient_c
        mean, covariance = touch.mean.copy(), touch.covariance.copy()
        mean[:, 0] = (mean[:, 0] - by_plate * plate_k) * scale
        covariance[:, 0, :] *= stated[:, None]
        covariance[:, :, 0] *= stated[:, None]
        differs_k = plate_k - mean[:, 0]
        spread_k, transferred_k = now(self._spread) * differs_k, by_plate * (plate_k - self._plate_k)
        covariance[:, 0, 0] += scale**2 * (spread_k**2 + transferred_k**2)
        ln_likelihood = now(self._sharpness) * touch.ln_likelihood
        unlike_k = mean[:, 0] - 0.5 * (self._coldest_k + self._warmest_k)
        beyond_k = np.maximum(np.abs(unlike_k) - 0.5 * (self._warmest_k - self._coldest_k), 0.0)
        common_k = np.stack((now(self._common) * differs_k, now(self._by_object_sd) * unlike_k, BEYOND * beyond_k))
        common_k2 = np.square(scale * common_k).sum(axis=0)
        return replace(touch, ln_likelihood=ln_likelihood, mean=mean, covariance=covariance, common_k2=common_k2)
