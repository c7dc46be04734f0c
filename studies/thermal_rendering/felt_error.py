"""Error of the temperature felt on a plate against that felt on the object itself, beside a finger's tolerance."""

from dataclasses import dataclass

import numpy as np

from operator_site.thermal.model_selection import TOLERANCE_K, TOLERANCE_SHARE
from studies.touches.simulated_finger import STEP_S, Array


@dataclass(frozen=True, slots=True)
class FeltError:
    """Error of one touch.

    Attributes:
        largest_k: largest error, either way, K.
        at_s: time of the largest error, s.
        share: largest ratio of the error to the tolerance at its time.
        twice_until_s: time from which the error stays within twice the tolerance, s.
        beyond_k: largest excess of the felt change over that on the object, K.
    """

    largest_k: float
    at_s: float
    share: float
    twice_until_s: float
    beyond_k: float


def tolerance_k(true_k: Array) -> Array:
    """Tolerated error at a change `true_k` of the felt temperature, K."""
    return np.asarray(np.maximum(TOLERANCE_K, TOLERANCE_SHARE * np.abs(true_k)))


def felt_error(felt_k: Array, true_k: Array) -> FeltError:
    """Compare changes of the felt temperature, K, every STEP_S from contact on."""
    error = felt_k - true_k
    shares = np.abs(error) / tolerance_k(true_k)
    twice = np.flatnonzero(shares > 2.0)
    worst = int(np.abs(error).argmax())
    return FeltError(
        float(np.abs(error[worst])),
        STEP_S * worst,
        float(shares.max()),
        STEP_S * float(twice[-1] + 1) if len(twice) else 0.0,
        float((np.sign(true_k[-1]) * error).max()),
    )
