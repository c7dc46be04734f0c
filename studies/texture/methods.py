"""Answers of each method after some time of stroking: the paper's method, the shipped one, and two classic ones."""

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.calibration.law_fit import LabelledStroke, anything
from remote_site.texture.calibration.texture_calibration import TextureFit, fit_surfaces
from remote_site.texture.recorded.stroke_playback import StrokeBlock
from remote_site.texture.texture_law import TextureLaw
from studies.texture.baselines import band_powers, classifiers, moments
from studies.texture.paper_method import PaperClasses, PaperState, paper_states
from studies.texture.strokes import Drawn, stroke_blocks, stroking

Array = NDArray[np.float64]

PAPER, SHIPPED, BANDS, MOMENTS = "paper", "shipped", "band powers + random forest", "moments + linear discriminant"
METHODS = (PAPER, SHIPPED, BANDS, MOMENTS)
"""All methods, in the order of the times that `answers` returns."""
RATE_HZ = 2000.0


@dataclass(frozen=True, slots=True)
class Learned:
    """Calibration of all methods by the same strokes."""

    fit: TextureFit
    paper: PaperClasses
    classic: dict[tuple[str, float], Any]
    """Classifiers by method and time."""


def learn(drawn: Sequence[Drawn], times_s: Sequence[float]) -> Learned:
    """Calibrate every method with the same strokes."""
    fit = fit_surfaces([LabelledStroke(f"stroke {k}", one.asked.surface, one.even) for k, one in enumerate(drawn)], {})
    plain = anything(TextureLaw())
    blocks = [stroke_blocks(one, plain) for one in drawn]
    ends: dict[str, list[PaperState]] = {}
    for one, own in zip(drawn, blocks, strict=True):
        ends.setdefault(one.asked.surface, []).append(paper_states(one.even, [block.mode for block in own])[-1])
    names = [one.asked.surface for one in drawn]
    classic = {}
    for time_s in times_s:
        signals = [signal_of(one, own, time_s) for one, own in zip(drawn, blocks, strict=True)]
        forest, discriminant = classifiers().values()
        classic[BANDS, time_s] = forest.fit(np.array([band_powers(s, RATE_HZ) for s in signals]), names)
        classic[MOMENTS, time_s] = discriminant.fit(np.array([moments(s) for s in signals]), names)
    return Learned(fit, PaperClasses(ends), classic)


def signal_of(one: Drawn, blocks: Sequence[StrokeBlock], time_s: float) -> Array:
    """Return the first `time_s` of a stroke's signal, V."""
    begin_s = stroking(list(blocks))[0].begin_s
    inside = (one.even.time_s >= begin_s) & (one.even.time_s < begin_s + time_s)
    signal: Array = one.even.signal_v[inside]
    return signal


def answers(one: Drawn, learned: Learned, times_s: Sequence[float]) -> tuple[dict[tuple[str, float], str], Array]:
    """Return the surface that each method names at each time, and each method's time per second of signal, s.

    The times are in the order of METHODS.
    """
    begin = perf_counter()
    blocks = stroke_blocks(one, learned.fit.table)
    spent = [0.0, (perf_counter() - begin) / (len(one.even.time_s) / RATE_HZ), 0.0, 0.0]
    begin = perf_counter()
    course = paper_states(one.even, [block.mode for block in blocks])
    spent[0] = (perf_counter() - begin) / (len(course) * 0.005)
    stroked = stroking(blocks)
    found = {}
    for time_s in times_s:
        last = min(round(time_s / 0.005), len(stroked)) - 1
        found[SHIPPED, time_s] = stroked[last].texture.best
        found[PAPER, time_s] = learned.paper.surface(course[last])
        signal = signal_of(one, blocks, time_s)
        begin = perf_counter()
        found[BANDS, time_s] = str(learned.classic[BANDS, time_s].predict(band_powers(signal, RATE_HZ)[None])[0])
        between = perf_counter()
        found[MOMENTS, time_s] = str(learned.classic[MOMENTS, time_s].predict(moments(signal)[None])[0])
        spent[2], spent[3] = (between - begin) / time_s, (perf_counter() - between) / time_s
    return found, np.array(spent)
