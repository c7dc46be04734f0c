"""Turns one finger's touch packets into samples of temperature, stiffness, material and roughness on the bench.

A sample lies where it was measured. A finger that rests or presses in one place gives one sample of each quantity. The
sample is replaced as the estimate improves, so that a long touch counts like a short one. A stroke gives one roughness
sample every STROKE_STEP_M. The sample lies LATE_M behind the finger, because the remote site reports a change of the
surface only after that length.
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
"""Radius around the first contact within which a finger rests, m."""
USEFUL_SD_K = 2.0
"""Largest standard deviation of a usable temperature, K."""
LEAST_VARIANCE = 1e-4
"""Smallest variance of a sample: 0.01 K or 1 %, squared. A virtual environment reports its exact values."""
DWELL_S = 1.5
"""Shortest rest on a place before its temperature is sampled, s; the packets hold a temperature from first contact."""
PRESSES_SHARE = 0.8
"""Smallest force of a press as a share of the touch's largest force.

A finger that leaves is below it. Its estimate may doubt the stiffness, and is no sample.
"""
DWELL_EVERY_S = 0.1
"""Interval at which a resting finger's samples are replaced, s."""
FIRST_M = 0.030
"""Longest path that the first roughness of a stroke describes, m: 0.1 s of a fast stroke, between two summaries."""
STROKE_STEP_M = 1.5e-3
"""Distance between two roughness samples along a stroke, m."""
LATE_M = 6e-3
"""Distance of a roughness sample behind the finger, m: 5 mm to identify a new surface and 1 mm to detect grooves."""
STROKE_SHARE = math.sqrt(2.0 * math.pi)
"""Number of neighbouring stroke samples that are worth one independent sample; the kernel is as wide as their step."""
_PATH_STEP_M = 0.5e-3
"""Smallest distance between two stored places of a stroke, m."""
_TEMPERATURE_KNOWN = frozenset(float(status) for status in ThermalStatus if status > ThermalStatus.NO_CONTACT)


class Sample(NamedTuple):
    """One quantity at one place.

    Attributes:
        quantity: "temperature" (C), "roughness" (ln of V), "stiffness" (ln of N/m), "material" (probability), or
            "slant" (1: the surface is steep here).
        key: identifier; a sample replaces the sample of its quantity with the same key.
        touch: number of the contact, unique for a finger.
        finger: number of the finger.
        x_m, y_m: place on the bench.
        t_s: time of the sample, s.
        value, variance: in the quantity's unit and its square.
        name: name of the material.
        force_n: force of the press, N; 0 where it is not known.
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
    force_n: float = 0.0


def slant(t_s: float, finger: int, x_m: float, y_m: float) -> Sample:
    """Return the sample of a finger in contact with a steep surface; it counts as no touch and is never replaced."""
    return Sample("slant", (finger, 0, 0), 0, finger, x_m, y_m, t_s, 1.0, LEAST_VARIANCE)


def samples_of(record: Mapping[str, Any]) -> list[Sample]:
    """Return the samples in a record of `console/felt`.

    Raises:
        KeyError, TypeError, ValueError: the record holds no valid samples.
    """
    found = [Sample(quantity, (*key,), *rest) for quantity, key, *rest in record["samples"]]
    for each in found:
        known = math.isfinite(each.x_m + each.y_m + each.t_s + each.value + each.force_n)
        if not (known and 0.0 < each.variance < math.inf):
            raise ValueError(f"{each.quantity}: a number of the sample is not possible")
    return found


class FingerSamples:
    """Makes the samples of one finger. Pure; step it with every packet."""

    def __init__(self, finger: int) -> None:
        self._finger = finger
        self._touch = 0
        self._contact = False
        self._still = False
        self._from_m = (0.0, 0.0)
        self._touched_s = self._sampled_s = -math.inf
        self._largest_n = 0.0
        self._reported_v: float | None = None
        self._reported_m = 0.0
        self._roughness: tuple[float, float] | None = None
        """Newest roughness reported in this stroke, as value and variance of a sample."""
        self._path: deque[tuple[float, float, float]] = deque()
        """Path length, m, and places of the stroke, as far back as samples are still due."""
        self._painted_m = 0.0
        self._lost = False
        """Whether the roughness became unknown within this stroke."""
        self._strokes = 0

    def count_from(self, touch: int) -> None:
        """Number the next touch above `touch`."""
        self._touch = max(self._touch, touch)

    def step(self, t_s: float, row: TouchRow, summary: TouchSummary) -> list[Sample]:
        """Take one packet; return the new samples."""
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
            self._largest_n = 0.0
            self._touched_s = self._sampled_s = t_s  # the summary still belongs to the contact before
            self._begin_stroke(summary)
        self._largest_n = max(self._largest_n, row.contact_force_n)
        if row.mode == ExplorationMode.STROKING:
            self._still = False
            return self._stroke(t_s, x_m, y_m, summary)
        if self._path:
            ended = self._paint(t_s, self._path[-1][0] - LATE_M)
            self._begin_stroke(summary)
            return ended
        self._still = self._still and math.dist(self._from_m, (x_m, y_m)) < STILL_M
        if not self._still or t_s - self._sampled_s < DWELL_EVERY_S:
            return []
        self._sampled_s = t_s
        return self._rest(t_s, row, summary)

    def _rest(self, t_s: float, row: TouchRow, summary: TouchSummary) -> list[Sample]:
        """Return the samples of a finger that has rested since its contact began."""
        samples = []
        dwelt = t_s - self._touched_s >= DWELL_S
        if dwelt and row.thermal_status in _TEMPERATURE_KNOWN and row.object_c_sd <= USEFUL_SD_K:
            samples.append(self._sample("temperature", t_s, *self._from_m, row.object_c, row.object_c_sd**2))
        presses = row.contact_force_n >= PRESSES_SHARE * self._largest_n
        if presses and row.stiffness_n_m > 0.0 and row.stiffness_ln_sd < STIFFNESS_KNOWN_LN_SD:
            stiffness = math.log(row.stiffness_n_m)
            sample = self._sample("stiffness", t_s, *self._from_m, stiffness, row.stiffness_ln_sd**2)
            samples.append(sample._replace(force_n=row.contact_force_n))
        if row.thermal_status == ThermalStatus.IDENTIFIED and summary.candidates:
            name, probability = summary.candidates[0]
            samples.append(self._sample("material", t_s, *self._from_m, probability, 1.0)._replace(name=name))
        return samples

    def _stroke(self, t_s: float, x_m: float, y_m: float, summary: TouchSummary) -> list[Sample]:
        """Extend a stroke; return its samples of the places behind the finger."""
        path = self._path
        if not path:
            path.append((0.0, x_m, y_m))
        way_m, last_x_m, last_y_m = path[-1]
        step_m = math.dist((last_x_m, last_y_m), (x_m, y_m))
        if step_m >= _PATH_STEP_M:
            path.append((way_m + step_m, x_m, y_m))
        roughness_v = summary.roughness_v
        if roughness_v is None:
            return self._unknown(t_s)
        if roughness_v <= 0.0 or roughness_v == self._reported_v:
            return []
        # The surface changed somewhere on the path since the last report: assume the middle.
        samples = self._paint(t_s, 0.5 * (self._reported_m + path[-1][0]) - LATE_M)
        relative_sd = 1.0 if summary.roughness_sd_v is None else summary.roughness_sd_v / roughness_v
        self._reported_v, self._reported_m = roughness_v, path[-1][0]
        self._roughness = math.log(roughness_v), STROKE_SHARE * relative_sd**2
        return samples

    def _unknown(self, t_s: float) -> list[Sample]:
        """Return the last samples before the roughness became unknown; the path until it is known again has none."""
        way_m, samples = self._path[-1][0], []
        if self._roughness is not None:
            samples = self._paint(t_s, way_m - LATE_M)
            self._roughness = self._reported_v = None
            self._lost = True
        self._painted_m = max(self._painted_m, way_m - (LATE_M if self._lost else FIRST_M))
        self._trim()
        return samples

    def _paint(self, t_s: float, until_m: float) -> list[Sample]:
        """Return samples of the newest reported roughness for the path up to `until_m`, m."""
        samples = []
        while self._roughness is not None and self._painted_m <= until_m:
            place = _at(self._path, self._painted_m)
            self._painted_m += STROKE_STEP_M
            self._strokes += 1
            sample = self._sample("roughness", t_s, *place, *self._roughness)
            samples.append(sample._replace(key=(self._finger, self._touch, self._strokes)))
        self._trim()
        return samples

    def _trim(self) -> None:
        """Discard the path of which no more samples are due."""
        while len(self._path) > 2 and self._path[1][0] < self._painted_m:
            self._path.popleft()

    def _begin_stroke(self, summary: TouchSummary) -> None:
        """Discard the path and the roughness reported so far, which belong to the stroke before."""
        self._path.clear()
        self._painted_m = self._reported_m = 0.0
        self._roughness = None
        self._lost = False
        self._reported_v = summary.roughness_v

    def _sample(self, quantity: str, t_s: float, x_m: float, y_m: float, value: float, variance: float) -> Sample:
        key = (self._finger, self._touch, 0)
        return Sample(quantity, key, self._touch, self._finger, x_m, y_m, t_s, value, max(variance, LEAST_VARIANCE))


def _at(path: Sequence[tuple[float, float, float]], way_m: float) -> tuple[float, float]:
    """Return the place at a length along a path."""
    for (from_m, from_x, from_y), (to_m, to_x, to_y) in pairwise(path):
        if way_m <= to_m:
            share = (way_m - from_m) / (to_m - from_m)
            return from_x + share * (to_x - from_x), from_y + share * (to_y - from_y)
    return path[-1][1], path[-1][2]
