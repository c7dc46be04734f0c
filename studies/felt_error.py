"""How far what is felt on a plate is from what is felt on the object itself, beside what a finger tolerates."""

from dataclasses import dataclass

import numpy as np

from operator_site.model_choice import TOLERANCE_K, TOLERANCE_SHARE
from studies.simulated_finger import STEP_S, Array


@dataclass(frozen=True, slots=True)
class FeltError:
    """Of one touch.

    Attributes:
        largest_k: largest error, either way, K.
        at_s: when.
        share: largest error in tolerances of that moment.
        twice_until_s: from here on it stays within twice the tolerance.
        beyond_k: by how much more than on the object is felt at most, K.
    """

    largest_k: float
    at_s: float
    share: float
    twice_until_s: float
    beyond_k: float


def tolerance_k(true_k: Array) -> Array:
    """What an error may be while the felt temperature has changed by so much, K."""
    return np.asarray(np.maximum(TOLERANCE_K, TOLERANCE_SHARE * np.abs(true_k)))


def felt_error(felt_k: Array, true_k: Array) -> FeltError:
    """Compare changes of the felt temperature every STEP_S from contact on, K."""
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
