"""What the packets tell of the objects for a person to read: made anew ten times a second at most."""

import math
from collections.abc import Mapping

from common.fingers import FINGERS
from common.wire.touch_summary import (
    GROOVE_MAX_M,
    MAX_CANDIDATES,
    NOTHING,
    NOTHING_TOLD,
    ROUGHNESS_MAX_V,
    TOLD_EVERY_S,
    TouchSummary,
)
from remote_site.identification.finger_identification import FingerIdentification

UNLIKELY = 0.01
"""A material less probable than this is none of the candidates."""


class TouchSummaries:
    """Remembers what is told. Pure: the time is an argument.

    Attributes:
        told: of each finger, now; the same object until something else is told.
    """

    __slots__ = ("_made_s", "told")

    def __init__(self) -> None:
        """Nothing is told yet."""
        self._made_s = -math.inf
        self.told = NOTHING_TOLD

    def step(self, t_s: float, fingers: Mapping[int, FingerIdentification]) -> None:
        """Take what is identified of the fingers in use at `t_s`, s, when it is time to."""
        if 0.0 <= t_s - self._made_s < TOLD_EVERY_S:
            return
        self._made_s = t_s
        told = tuple([NOTHING if (finger := fingers.get(k)) is None else _told(finger) for k in range(len(FINGERS))])
        if told != self.told:
            self.told = told


def _told(finger: FingerIdentification) -> TouchSummary:
    """One finger's, within what a packet may say: what an estimator says beyond that saturates there."""
    if not finger.contact:
        return NOTHING
    ranked = sorted(finger.answer.candidates.items(), key=lambda named: -named[1])
    told = TouchSummary(tuple([(name, min(1.0, p)) for name, p in ranked[:MAX_CANDIDATES] if p >= UNLIKELY]))
    if (roughness_v := finger.roughness_v) is not None:
        value_v, sd_v = roughness_v
        told = told._replace(roughness_v=min(value_v, ROUGHNESS_MAX_V), roughness_sd_v=min(sd_v, ROUGHNESS_MAX_V))
    if (period := finger.period.estimate()) is not None:
        groove_m, sd_m = period.period_m, period.period_sd_m
        told = told._replace(groove_m=min(groove_m, GROOVE_MAX_M), groove_sd_m=min(sd_m, GROOVE_MAX_M))
    return told
