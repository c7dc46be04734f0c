"""Makes the summary of the touched objects that a person reads, at most ten times a second."""

import math
from collections.abc import Mapping

from common.fingers import FINGERS
from common.wire.touch_summary import (
    GROOVE_MAX_M,
    MAX_CANDIDATES,
    NO_SUMMARIES,
    NOTHING,
    ROUGHNESS_MAX_V,
    SUMMARY_INTERVAL_S,
    TouchSummary,
)
from remote_site.identification.finger_identification import FingerIdentification

UNLIKELY = 0.01
"""Smallest probability of a material that is listed as a candidate, 0..1."""


class TouchSummaries:
    """Keeps the present summaries. Pure: the time is an argument.

    Attributes:
        summaries: present summary of each finger; the same object until a summary changes.
    """

    def __init__(self) -> None:
        """Begin with empty summaries."""
        self._made_s = -math.inf
        self.summaries = NO_SUMMARIES

    def step(self, t_s: float, fingers: Mapping[int, FingerIdentification]) -> None:
        """Summarise the fingers in use at `t_s`, s, if the interval since the last summary has passed."""
        if 0.0 <= t_s - self._made_s < SUMMARY_INTERVAL_S:
            return
        self._made_s = t_s
        made = tuple([NOTHING if (finger := fingers.get(k)) is None else _summary(finger) for k in range(len(FINGERS))])
        if made != self.summaries:
            self.summaries = made


def _summary(finger: FingerIdentification) -> TouchSummary:
    """Summarise one finger; values saturate at the limits of the packet."""
    if not finger.contact:
        return NOTHING
    ranked = sorted(finger.thermal.answer.candidates.items(), key=lambda named: -named[1])
    summary = TouchSummary(tuple([(name, min(1.0, p)) for name, p in ranked[:MAX_CANDIDATES] if p >= UNLIKELY]))
    if (roughness := finger.roughness) is not None:
        value_v, sd_v = roughness
        summary = summary._replace(roughness_v=min(value_v, ROUGHNESS_MAX_V), roughness_sd_v=min(sd_v, ROUGHNESS_MAX_V))
    if (period := finger.period.estimate()) is not None and not period.irregular:
        groove_m, sd_m = period.period_m, period.period_sd_m
        summary = summary._replace(groove_m=min(groove_m, GROOVE_MAX_M), groove_sd_m=min(sd_m, GROOVE_MAX_M))
    return summary
