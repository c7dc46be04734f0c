"""A person who compares two touches by temperature: from two cues to the shares of three answers, without a fit.

The cue is the logarithm of how far the felt temperature went from where it was. A person tells two cues apart as they
tell two rates of heat extraction apart: a Weber fraction of 0.43 (Bergmann Tiest & Kappers 2009), taken as the
difference at which 79.4 % of two-alternative answers are right. What is nearer than it is called equal.
"""

import math
from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

WEBER = 0.43
RIGHT_SD = 0.82
"""79.4 % of a normal law lies below so many standard deviations."""
CRITERION = math.log(1.0 + WEBER)
NOISE = CRITERION / RIGHT_SD
LAPSE = 0.03
"""Declared, not fitted: so much is answered without looking, each of the three answers alike."""


class Answers(NamedTuple):
    """Shares of the answers about two cold objects, 0..1: the first is felt colder, equal, less cold."""

    colder: float
    equal: float
    warmer: float


def cue(change_k: float) -> float:
    """Of a touch that changed the felt temperature by so much, K; not 0."""
    return math.log(abs(change_k))


def answers(difference: float, lapse: float = LAPSE) -> Answers:
    """Shares of the answers where the cues of first and second object differ by `difference`."""
    colder = _below((difference - CRITERION) / NOISE)
    warmer = _below((-difference - CRITERION) / NOISE)
    return Answers(*((1.0 - lapse) * share + lapse / 3.0 for share in (colder, 1.0 - colder - warmer, warmer)))


def answers_about(first_k: Sequence[float], second_k: Sequence[float], lapse: float = LAPSE) -> Answers:
    """Mean over all pairs of one object's touches with the other's, each by its change of felt temperature, K."""
    cases = [answers(cue(first) - cue(second), lapse) for first, second in product(first_k, second_k)]
    return Answers(*(sum(shares) / len(cases) for shares in zip(*cases, strict=True)))


def _below(deviations: float) -> float:
    return 0.5 * math.erfc(-deviations / math.sqrt(2.0))
