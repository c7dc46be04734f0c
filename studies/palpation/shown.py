"""Judges what would be shown of recorded presses, and the stiffness along a stream: known share and repeats."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from remote_site.stiffness.recorded.identify_stiffness import StiffnessAnswer, identify_presses
from remote_site.stiffness.surface_estimate import SurfaceEstimate
from remote_site.traces.press_files import Press
from studies.palpation.recordings import Stream

Array = NDArray[np.float64]
Row = dict[str, Any]

STEP_S = 1.5
"""Time between the steps of a press whose times are unknown, s."""
TOO_HARD_N = 0.1
"""Excess of the shown force that counts as too hard, N."""
LONGEST_PERIOD_S, SHORTEST_PERIOD_S = 0.8, 0.3
LAW, STEPPED, DRAWN = "tangent of the law", "live, steps", "live, one motion"
LIVE, RECORDED, REGRESSION = "live", "recorded", "regression over a period"
DRAWN_S, TICK_S = 1.0, 0.004
"""Duration of a press as one motion, and time between its samples, s."""


def shown(name: str, presses: Sequence[Press]) -> list[Row]:
    """Count presses that are shown too hard at any recorded depth: live, and by the tangent of the recorded law."""
    of_law = [
        [_tangent_excess_n(press, answer)]
        for press, answer in zip(presses, identify_presses(presses), strict=True)
        if answer["model"] is not None
    ]
    rows = [_shown_row(name, LAW, of_law)]
    for way, motion in ((STEPPED, _steps), (DRAWN, _drawn)):
        rows.append(_shown_row(name, way, [_live_excesses_n(press, *motion(press)) for press in presses]))
    return rows


def _shown_row(name: str, way: str, excesses_n: Sequence[Sequence[float]]) -> Row:
    """Make the row of a set from the excesses of each press while its stiffness was known."""
    worst_n = np.array([max(excesses, default=0.0) for excesses in excesses_n])
    return {
        "set": name,
        "way": way,
        "presses": len(worst_n),
        "known": sum(len(excesses) > 0 for excesses in excesses_n),
        "too_hard": float(np.mean(worst_n > TOO_HARD_N)),
        "excess_p95_n": float(np.quantile(worst_n, 0.95)),
    }


def _tangent_excess_n(press: Press, answer: StiffnessAnswer) -> float:
    """Return the largest excess, N, of the tangent of the law at the deepest sample, over all samples."""
    model = answer["model"]
    assert model is not None
    depth_mm, force_n = np.array(model["depth_mm"]), np.array(model["force_n"])
    last = int(np.searchsorted(depth_mm, press.depth_mm.max()))
    slope = (force_n[last] - force_n[last - 1]) / (depth_mm[last] - depth_mm[last - 1])
    line_n = np.maximum(0.0, force_n[last] + slope * (press.depth_mm - depth_mm[last]))
    return float((line_n - press.force_n).max())


def _live_excesses_n(press: Press, time_s: Array, depth_mm: Array, force_n: Array) -> list[float]:
    """Press live; return the excess over all recorded samples, N, at each time at which the stiffness is known."""
    surface, excesses = SurfaceEstimate(), []
    for t_s, deep_mm, newton in zip(time_s.tolist(), depth_mm.tolist(), force_n.tolist(), strict=True):
        surface.step(t_s, newton, 0.0, 0.0, -1e-3 * deep_mm)
        if surface.known:
            shown_n = surface.stiffness_n_m * np.maximum(0.0, surface.surface_z_m + 1e-3 * press.depth_mm)
            excesses.append(float((shown_n - press.force_n).max()))
    return excesses


def _steps(press: Press) -> tuple[Array, Array, Array]:
    """Return the samples at their times; steps without times are STEP_S apart."""
    even_s: Array = STEP_S * np.arange(len(press.depth_mm), dtype=np.float64)
    return even_s if press.time_s is None else press.time_s, press.depth_mm, press.force_n


def _drawn(press: Press) -> tuple[Array, Array, Array]:
    """Return the press as one motion through its samples, without further noise."""
    depth_mm, first_of = np.unique(press.depth_mm, return_index=True)
    time_s = np.arange(0.0, DRAWN_S, TICK_S, dtype=np.float64)
    deep_mm = depth_mm[0] + (depth_mm[-1] - depth_mm[0]) / DRAWN_S * time_s
    return time_s, deep_mm, np.asarray(PchipInterpolator(depth_mm, press.force_n[first_of])(deep_mm))


def streamed(name: str, stream: Stream) -> list[Row]:
    """Identify live along a stream; judge the end of each period of the force, beside a regression over it."""
    period_s = _period_s(stream)
    surface, live = SurfaceEstimate(), []
    x_m, y_m, z_m = (1e-3 * stream.place_mm).T.tolist()
    for row in zip(stream.time_s.tolist(), stream.force_n.tolist(), x_m, y_m, z_m, strict=True):
        surface.step(*row)
        live.append((surface.stiffness_n_m, surface.known))
    stiffness, known = np.array(live).T
    edges = np.searchsorted(stream.time_s, np.arange(stream.time_s[0], stream.time_s[-1], period_s))
    windows = [slice(a, b) for a, b in pairwise(edges.tolist()) if b - a > 10]
    ends = np.array([window.stop - 1 for window in windows])
    odd, even = ([slice(window.start + first, window.stop, 2) for window in windows] for first in (1, 0))
    answers = _answers(stream, windows)
    known_share = float(np.mean([answer["status"] == "known" for answer in answers]))
    recorded_cv = pair_cv(*(_stiffness_n_m(_answers(stream, half)) for half in (odd, even)))
    regression_cv = pair_cv(*(_regressions_n_m(stream, half) for half in (odd, even)))
    return [
        {"stream": name, "method": method, "windows": len(windows), "known": share}
        | {"cv": neighbour_cv(values), "cv_of_halves": of_halves}
        for method, share, values, of_halves in (
            (LIVE, float(known[ends].mean()), stiffness[ends], None),
            (RECORDED, known_share, _stiffness_n_m(answers), recorded_cv),
            (REGRESSION, None, _regressions_n_m(stream, windows), regression_cv),
        )
    ]


def neighbour_cv(stiffness_n_m: Array) -> float:
    """Return the coefficient of variation of one window: robust, from its difference to the mean of its neighbours.

    The probe moves on between windows. The mean of both neighbours removes a trend of the tissue.
    """
    ln = np.log(np.maximum(stiffness_n_m, 1.0))
    bend = ln[1:-1] - 0.5 * (ln[:-2] + ln[2:])
    return _robust_sd(bend) / math.sqrt(1.5)


def pair_cv(one_n_m: Array, other_n_m: Array) -> float:
    """Return the coefficient of variation of one of two estimates of the same windows: robust, from their ratio."""
    ln = np.log(one_n_m / other_n_m)
    return _robust_sd(ln[np.isfinite(ln)]) / math.sqrt(2.0)


def _robust_sd(values: Array) -> float:
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def _period_s(stream: Stream) -> float:
    """Return the period of the force's sine, s."""
    step_s = float(np.median(np.diff(stream.time_s)))
    even_s = np.arange(stream.time_s[0], stream.time_s[-1], step_s)
    force_n = np.interp(even_s, stream.time_s, stream.force_n)
    size = 2 ** int(np.ceil(np.log2(8 * len(force_n))))
    power = np.abs(np.fft.rfft((force_n - force_n.mean()) * np.hanning(len(force_n)), size))
    hertz = np.fft.rfftfreq(size, step_s)
    allowed = (hertz >= 1.0 / LONGEST_PERIOD_S) & (hertz <= 1.0 / SHORTEST_PERIOD_S)
    return float(1.0 / hertz[allowed][power[allowed].argmax()])


def _press(number: int, stream: Stream, window: slice) -> Press:
    """Return a window as a press, with depth from the highest place of the probe."""
    height_mm = stream.place_mm[window, 2]
    return Press(number, height_mm.max() - height_mm, stream.force_n[window], stream.time_s[window])


def _answers(stream: Stream, windows: Sequence[slice]) -> list[StiffnessAnswer]:
    return identify_presses([_press(k, stream, window) for k, window in enumerate(windows)])


def _stiffness_n_m(answers: Sequence[StiffnessAnswer]) -> Array:
    return np.array([answer["stiffness_n_m"] or np.nan for answer in answers])


def _regressions_n_m(stream: Stream, windows: Sequence[slice]) -> Array:
    places = ((-1e-3 * stream.place_mm[window, 2], stream.force_n[window]) for window in windows)
    return np.array([np.polyfit(depth_m, force_n, 1)[0] for depth_m, force_n in places])
