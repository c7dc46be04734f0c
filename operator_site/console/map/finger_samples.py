"""What one finger's touch packets tell of the place it touches: samples of temperature, stiffness, material, roughness.

A sample stands where it was felt. A finger that rests or presses in one place gives one of each quantity, which is
replaced while the touch goes on and the estimate gets better: a long touch is no more touches than a short one. A
stroke gives one roughness every STROKE_STEP_M, LATE_M behind the finger: a change of the surface is told when so much
of it has been felt.
"""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from common.fingers import FINGER_Y_M
from common.wire.messages import STIFFNESS_KNOWN_LN_SD, ExplorationMode, ThermalStatus, TouchRow
from common.wire.touch_summary import TouchSummary

STILL_M = 3e-3
"""A finger that has not been farther than this from where it came down rests, m."""
USEFUL_SD_K = 2.0
"""A temperature that is known no better is not known."""
LEAST_VARIANCE = 1e-4
"""Nothing is known better than 0.01 K or 1 %, whatever is told: a virtual environment tells what it is."""
DWELL_S = 1.5
"""A temperature is told from the first moment on; a place that was rested on for less than this is not known by it."""
DWELL_EVERY_S = 0.1
"""A resting finger's samples are replaced so often."""
STROKE_STEP_M = 1.5e-3
LATE_M = 6e-3
"""The remote site tells a new surface when it has felt 5 mm of it, and 1 mm more is kept back for grooves."""
STROKE_SHARE = math.sqrt(2.0 * math.pi)
"""Neighbouring samples of a stroke tell the same: so many of them together are worth one, by a kernel as wide as their
step."""
_PATH_STEP_M = 0.5e-3
_TEMPERATURE_KNOWN = frozenset(float(status) for status in ThermalStatus if status > ThermalStatus.NO_CONTACT)


class Sample(NamedTuple):
    """One quantity felt at one place.

    Attributes:
        quantity: "temperature" (C), "roughness" (ln of V), "stiffness" (ln of N/m), "material" (probability), or
            "slant" (1: the surface is steep here).
        key: a sample replaces the one of its quantity that has the same key.
        touch: number of the contact that it comes from; unique for a finger.
        finger: number of the finger.
        x_m, y_m: place on the bench.
        t_s: when it was felt.
        value, variance: in the quantity's unit, and its square.
        name: of the material.
    """

    quantity: str
    key: tuple[int, int, int]
    touch: int
    finger: int
    x_m: float
    y_m: float
    t_s: float
    value: float
    variance: float
    name: str = ""


def slant(t_s: float, finger: int, x_m: float, y_m: float) -> Sample:
    """A finger in contact where the surface is steep; no touch is counted for it, and nothing replaces it."""
    return Sample("slant", (finger, 0, 0), 0, finger, x_m, y_m, t_s, 1.0, LEAST_VARIANCE)


def samples_of(record: Mapping[str, Any]) -> list[Sample]:
    """The samples that a record of `console/felt` holds.

    Raises:
        KeyError, TypeError, ValueError: it holds none.
    """
    return [Sample(quantity, (*key,), *rest) for quantity, key, *rest in record["samples"]]


class FingerSamples:
    """Samples of one finger. Pure; step it with every packet."""

    def __init__(self, finger: int) -> None:
        """A finger that has touched nothing yet."""
        self._finger = finger
        self._touch = 0
        self._contact = False
        self._still = False
        self._from_m = (0.0, 0.0)
        self._touched_s = self._sampled_s = -math.inf
        self._told: float | None = None
        self._told_m = 0.0
        self._felt: tuple[float, float] | None = None
        """What was told last in this stroke, as value and variance of a sample."""
        self._path: deque[tuple[float, float, float]] = deque()
        """Way, m, and place of the stroke so far, as far back as samples may still come from."""
        self._painted_m = 0.0
        self._strokes = 0

    def count_from(self, touch: int) -> None:
        """So many touches at least were counted before the next one."""
        self._touch = max(self._touch, touch)

    def step(self, t_s: float, row: TouchRow, told: TouchSummary) -> list[Sample]:
        """Take one packet.

        Args:
            t_s: time, s.
            row: the finger's.
            told: what is told of it slowly.
        """
        if row.contact == 0.0:
            ended = self._paint(t_s, self._path[-1][0] - LATE_M) if self._path else []
            self._path.clear()
            self._contact = False
            return ended
        x_m, y_m = row.x_m, row.y_m + FINGER_Y_M[self._finger]
        if not self._contact:
            self._contact, self._still = True, True
            self._touch += 1
            self._from_m = x_m, y_m
            self._touched_s = self._sampled_s = t_s  # what is told in the first moment is of the contact before
            self._begin_stroke(told)
        if row.mode == ExplorationMode.STROKING:
            self._still = False
            return self._stroke(t_s, x_m, y_m, told)
        if self._path:
            ended = self._paint(t_s, self._path[-1][0] - LATE_M)
            self._begin_stroke(told)
            return ended
        self._still = self._still and math.dist(self._from_m, (x_m, y_m)) < STILL_M
        if not self._still or t_s - self._sampled_s < DWELL_EVERY_S:
            return []
        self._sampled_s = t_s
        return self._rest(t_s, row, told)

    def _rest(self, t_s: float, row: TouchRow, told: TouchSummary) -> list[Sample]:
        """What a finger that has not moved since it came down knows of the place."""
        samples = []
        dwelt = t_s - self._touched_s >= DWELL_S
        if dwelt and row.thermal_status in _TEMPERATURE_KNOWN and row.object_c_sd <= USEFUL_SD_K:
            samples.append(self._sample("temperature", t_s, *self._from_m, row.object_c, row.object_c_sd**2))
        if row.stiffness_n_m > 0.0 and row.stiffness_ln_sd < STIFFNESS_KNOWN_LN_SD:
            stiffness = math.log(row.stiffness_n_m)
            samples.append(self._sample("stiffness", t_s, *self._from_m, stiffness, row.stiffness_ln_sd**2))
        if row.thermal_status == ThermalStatus.IDENTIFIED and told.candidates:
            name, probability = told.candidates[0]
            samples.append(self._sample("material", t_s, *self._from_m, probability, 1.0)._replace(name=name))
        return samples

    def _stroke(self, t_s: float, x_m: float, y_m: float, told: TouchSummary) -> list[Sample]:
        """What a stroke tells of the places that it has left behind."""
        path = self._path
        if not path:
            path.append((0.0, x_m, y_m))
        way_m, last_x_m, last_y_m = path[-1]
        step_m = math.dist((last_x_m, last_y_m), (x_m, y_m))
        if step_m >= _PATH_STEP_M:
            path.append((way_m + step_m, x_m, y_m))
        roughness_v = told.roughness_v
        if roughness_v is None or roughness_v <= 0.0 or roughness_v == self._told:
            return []
        # It became this somewhere on the way since the last telling.
        samples = self._paint(t_s, 0.5 * (self._told_m + path[-1][0]) - LATE_M)
        relative_sd = 1.0 if told.roughness_sd_v is None else told.roughness_sd_v / roughness_v
        self._told, self._told_m = roughness_v, path[-1][0]
        self._felt = math.log(roughness_v), STROKE_SHARE * relative_sd**2
        return samples

    def _paint(self, t_s: float, until_m: float) -> list[Sample]:
        """What was told last holds for the way up to `until_m`."""
        samples = []
        while self._felt is not None and self._painted_m <= until_m:
            place = _at(self._path, self._painted_m)
            self._painted_m += STROKE_STEP_M
            self._strokes += 1
            sample = self._sample("roughness", t_s, *place, *self._felt)
            samples.append(sample._replace(key=(self._finger, self._touch, self._strokes)))
        while len(self._path) > 2 and self._path[1][0] < self._painted_m:
            self._path.popleft()
        return samples

    def _begin_stroke(self, told: TouchSummary) -> None:
        """What has been told so far is of another way than the next stroke's."""
        self._path.clear()
        self._painted_m = self._told_m = 0.0
        self._felt = None
        self._told = told.roughness_v

    def _sample(self, quantity: str, t_s: float, x_m: float, y_m: float, value: float, variance: float) -> Sample:
        key = (self._finger, self._touch, 0)
        return Sample(quantity, key, self._touch, self._finger, x_m, y_m, t_s, value, max(variance, LEAST_VARIANCE))


def _at(path: Sequence[tuple[float, float, float]], way_m: float) -> tuple[float, float]:
    """Place at a way along a path."""
    for (from_m, from_x, from_y), (to_m, to_x, to_y) in pairwise(path):
        if way_m <= to_m:
            share = (way_m - from_m) / (to_m - from_m)
            return from_x + share * (to_x - from_x), from_y + share * (to_y - from_y)
    return path[-1][1], path[-1][2]
