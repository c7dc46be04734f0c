"""Describes the force of whole presses by a few numbers each, for the search of nodules.

The numbers are natural logarithms of the mean force in two parts of the depth. Ground changes both alike, and a nodule
below the surface changes the deeper one more. A power law of the median press gives the depth of tissue at contact and
the exponent. Breathing moves the surface after contact by a sine, of a rate that is fitted to all presses.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from operator_site.palpation.nodule_search import PressNumbers

Floats = NDArray[np.float64]
PARTS = ((0.2, 0.55), (0.7, 1.0))
"""Parts of the depth of a press whose mean forces make its numbers, as shares of the deepest reading."""
FEWEST_STEPS = 6
"""Smallest number of readings of a press."""
LEAST_N = 0.02
"""Smallest force whose logarithm is taken, N."""
LEAST_NOISE_N = 1e-3
"""Smallest standard deviation of a reading, N."""
UNKNOWN_VARIANCE = 100.0
"""Variance of a number whose force was not measured."""
BREATHS_PER_MIN = (8.0, 30.0)
"""Rates of breathing of a resting adult."""
BREATH_SD_M = 0.3e-3
"""Standard deviation of the cosine and of the sine of the surface's motion in the prior, m."""
_RATES = 201
_TYPICAL_SD = 0.06
_ORDER = 3
"""Order of the differences of successive forces that show the noise."""


def press_numbers(
    places_m: Floats,
    depth_m: Floats,
    force_n: Floats,
    contact_n: float,
    probe_radius_m: float,
    since_contact_s: Floats,
    contact_s: Floats,
) -> PressNumbers:
    """Return the numbers of presses with the same steps of depth.

    Args:
        places_m: places, (n, 2), m.
        depth_m: depths of the readings below the place of contact, (steps,), m, ascending, above 0.
        force_n: forces, (n, steps), N; NaN where a press has no reading.
        contact_n: force at contact, N, above 0.
        probe_radius_m: radius of the probe, m.
        since_contact_s: times of the readings since contact, (steps,), s.
        contact_s: times of the contacts, (n,), s.

    Raises:
        ValueError: there are fewer than FEWEST_STEPS readings.
    """
    if len(depth_m) < FEWEST_STEPS:
        raise ValueError(f"a press needs {FEWEST_STEPS} readings; there are {len(depth_m)}")
    share = depth_m / depth_m[-1]
    parts = [np.flatnonzero((share > low) & (share <= high)) for low, high in PARTS]
    contact_m, exponent = _power_law(depth_m, force_n, contact_n)
    value, variance = (np.array(rows) for rows in zip(*(_number(force_n, part) for part in parts), strict=True))
    part_m = np.array([depth_m[part].mean() for part in parts])
    relative = BREATH_SD_M * exponent / (part_m + contact_m)
    times = [since_contact_s[part] for part in parts]
    columns = _breathing(value, variance, relative, times, contact_s)
    return PressNumbers(places_m, value, variance, part_m, contact_m, exponent, probe_radius_m, columns)


def _number(force_n: Floats, part: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """Return ln of the mean force in a part of each press, and its variance by noise, (n,) each."""
    mean = force_n[:, part].mean(axis=1)
    known = np.isfinite(mean)
    held = np.maximum(np.where(known, mean, np.median(mean[known]) if known.any() else 1.0), LEAST_N)
    around = force_n[:, max(part[0] - 1, 0) : part[-1] + 2]
    differences = np.abs(np.diff(around, n=_ORDER, axis=1))
    differences = differences[np.isfinite(differences)]
    typical_n = float(np.median(differences)) if len(differences) else 0.0
    noise_n = max(1.4826 * typical_n / math.sqrt(math.comb(2 * _ORDER, _ORDER)), LEAST_NOISE_N)
    return np.log(held), np.where(known, (noise_n / held) ** 2 / len(part), UNKNOWN_VARIANCE)


def _power_law(depth_m: Floats, force_n: Floats, contact_n: float) -> tuple[float, float]:
    """Return the depth of the tissue at contact, m, and the exponent of the force of the median press."""
    course_n = np.median(np.where(np.isfinite(force_n), force_n, np.inf), axis=0)
    known = np.isfinite(course_n)
    if known.sum() < 2:
        return 0.0, 1.5
    ratio = np.log(np.maximum(course_n[known], LEAST_N) / contact_n)

    def misfit(by: Floats) -> Floats:
        return np.asarray(by[1] * np.log1p(depth_m[known] / math.exp(by[0])) - ratio)

    fitted = least_squares(misfit, [math.log(1e-3), 1.8], bounds=([math.log(2e-5), 1.0], [math.log(8e-3), 4.5])).x
    return math.exp(fitted[0]), float(fitted[1])


def _breathing(value: Floats, variance: Floats, relative: Floats, times: list[Floats], contact_s: Floats) -> Floats:
    """Return the effects of breathing on the numbers in first and second order, (columns, k, n).

    Args:
        value, variance: the numbers, (k, n).
        relative: change of each number by a rise of BREATH_SD_M, (k,).
        times: times of the readings of each number since contact, s.
        contact_s: times of the contacts, (n,), s.
    """

    def columns(per_min: Floats) -> Floats:
        """Return the effects at some rates, (rates, columns, k * n)."""
        turn_s = 2.0 * math.pi / 60.0 * per_min[:, None, None]
        found = np.zeros((len(per_min), 4, len(value), *value.shape))
        for number, since_s in enumerate(times):
            now, start = turn_s * (contact_s[:, None] + since_s), turn_s * contact_s[:, None]
            cosine, sine = np.cos(now) - np.cos(start), np.sin(now) - np.sin(start)
            # The squares of both add up to a constant, so that one of them is enough.
            rises = (cosine, sine, relative[number] * cosine * cosine, relative[number] * cosine * sine)
            for order, rise in enumerate(rises):
                found[:, order, number, number] = relative[number] * rise.mean(axis=2)
        return found.reshape(len(per_min), -1, value.size)

    deviation = np.sqrt(variance + _TYPICAL_SD**2)
    off = ((value - np.median(value, axis=1, keepdims=True)) / deviation).ravel()
    rates = columns(np.linspace(*BREATHS_PER_MIN, _RATES))
    basis = np.linalg.qr((rates / deviation.ravel()).transpose(0, 2, 1))[0]
    explained = np.square(off @ basis).sum(axis=1)
    return np.asarray(rates[int(explained.argmax())].reshape(-1, *value.shape))
