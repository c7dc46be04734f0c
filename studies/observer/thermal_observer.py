"""Psychophysical observer that compares two touches by temperature, with three possible answers and no fitted value.

The cue is the logarithm of the change of the felt temperature. The JND of two cues is that of two rates of heat
extraction, a Weber fraction of 0.43 (Bergmann Tiest & Kappers 2009). It is taken as the difference with 79.4 % right
answers in a two-alternative choice. The observer calls a smaller difference equal.
"""

import math
from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

WEBER = 0.43
RIGHT_SD = 0.82
"""Standard score below which 79.4 % of a normal distribution lies."""
CRITERION = math.log(1.0 + WEBER)
NOISE = CRITERION / RIGHT_SD
LAPSE = 0.03
"""Share of random answers, 0..1, equally among the three; declared, not fitted."""


class Answers(NamedTuple):
    """Shares of the answers about two cold objects, 0..1: the first feels colder, equal, or less cold."""

    colder: float
    equal: float
    warmer: float


def cue(change_k: float) -> float:
    """Return the cue of a touch with this change of the felt temperature, K; not 0."""
    return math.log(abs(change_k))


def answers(difference: float, lapse: float = LAPSE) -> Answers:
    """Return the shares of the answers if the cue of the first object exceeds that of the second by `difference`."""
    colder = _below((difference - CRITERION) / NOISE)
    warmer = _below((-difference - CRITERION) / NOISE)
    return Answers(*((1.0 - lapse) * share + lapse / 3.0 for share in (colder, 1.0 - colder - warmer, warmer)))


def answers_about(first_k: Sequence[float], second_k: Sequence[float]) -> Answers:
    """Return the mean shares over all pairs of touches of two objects, given by their felt temperature changes, K."""
    cases = [answers(cue(first) - cue(second)) for first, second in product(first_k, second_k)]
    return Answers(*(sum(shares) / len(cases) for shares in zip(*cases, strict=True)))


def _below(deviations: float) -> float:
    return 0.5 * math.erfc(-deviations / math.sqrt(2.0))
