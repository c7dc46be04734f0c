"""Error of a receiver that reckons on after a lost packet: how large it is, how long it lasts, and when it ends."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from common.link.deadband import HEIGHT_M
from common.timing.timeouts import REFRESH_S
from studies.deadband.channel import Floats, Ticks, error_m, kept, sent
from studies.deadband.courses import Course

LIMIT_M = 0.5e-3
"""Limit of the error, m: 1 degree at the recordings' lever, less than a hand can perceive. The JND is 2.5 degrees in
finger joints, 2.0 in a wrist, and 0.8 in a shoulder, the most sensitive of all joints (Tan et al. 1994)."""
LOSSES = (0.0, 0.05, 0.20)
REPEATS_TRIED = (0, 1, 2)
SHOWN_S = 0.050
_CUT_EVERY_S = 0.5
_BEFORE_S, _AFTER_S = 0.2, 0.1
_ROUNDING_S = 1e-9


def lossy_rows(
    courses: Sequence[Course], reckoning: str, repeats: int, draws: int, seed: int
) -> Iterator[dict[str, Any]]:
    """A row for each loss rate, with one reckoning and number of repeats; the step is that of a finger's height."""
    sent_at = [sent(course, reckoning, HEIGHT_M, repeats) for course in courses]
    for loss in LOSSES:
        rng = np.random.default_rng([seed, repeats])
        errors, mended = list[Floats](), list[float]()
        for course, ticks in zip(courses, sent_at, strict=True):
            for _ in range(draws if loss else 1):
                arrives = kept(ticks, loss, rng)
                errors.append(error_m(course, reckoning, arrives))
                mended += _mended_m(ticks, arrives, errors[-1])
        period_s = 1.0 / courses[0].rate_hz
        above_s = [period_s * ticks for error in errors for ticks in _runs(error > LIMIT_M)]
        yield {
            "rate_hz": courses[0].rate_hz,
            "reckoning": reckoning,
            "repeats": repeats,
            "loss": loss,
            "sent_share": _share(sent_at),
            "largest_mm": 1e3 * max(float(error.max()) for error in errors),
            "above_share": sum(above_s) / (period_s * sum(map(len, errors))),
            "times_above": len(above_s),
            "above_longer_than_a_refresh": sum(time_s > REFRESH_S + _ROUNDING_S for time_s in above_s),
            "longest_above_ms": 1e3 * max(above_s, default=0.0),
            "mended": len(mended),
            "mended_p99_mm": 1e3 * float(np.quantile(mended, 0.99)) if mended else 0.0,
            "mended_largest_mm": 1e3 * max(mended, default=0.0),
            "right_again_ms": 1e3 * _right_again_s(courses, sent_at, reckoning, loss, rng),
        }


def after_loss_rows(
    courses: Sequence[Course], reckoning: str, repeats: int, draws: int, seed: int
) -> Iterator[dict[str, Any]]:
    """Error over the time after a lost packet that follows an arrived one, with a fifth of all packets lost."""
    rng, found = np.random.default_rng([seed, repeats]), []
    for course in courses:
        ticks = sent(course, reckoning, HEIGHT_M, repeats)
        for _ in range(draws):
            arrives = kept(ticks, LOSSES[-1], rng)
            found.append(_after_losses(course, ticks, arrives, error_m(course, reckoning, arrives)))
    times = np.concatenate(found)
    for after, error in enumerate(times.T):
        p50, p95, p99 = np.quantile(error, (0.5, 0.95, 0.99)).tolist()
        yield {
            "reckoning": reckoning,
            "repeats": repeats,
            "losses": len(times),
            "after_ms": 1e3 * after / courses[0].rate_hz,
            "p50_mm": 1e3 * p50,
            "p95_mm": 1e3 * p95,
            "p99_mm": 1e3 * p99,
        }


def _mended_m(ticks: Ticks, arrives: Ticks, error: Floats) -> list[float]:
    """Largest error from each packet that arrives after a lost one until the next is sent, m."""
    numbers = np.flatnonzero(ticks).tolist()
    return [
        float(error[at:until].max())
        for before, at, until in zip(numbers, numbers[1:], numbers[2:], strict=False)
        if arrives[at] and not arrives[before]
    ]


def _after_losses(course: Course, ticks: Ticks, arrives: Ticks, error: Floats) -> Floats:
    """Errors from each lost packet on, (losses, time); only losses that follow an arrived packet count."""
    numbers = np.flatnonzero(ticks)
    lost = ~arrives[numbers]
    first = numbers[1:][lost[1:] & ~lost[:-1]]
    length = round(SHOWN_S * course.rate_hz)
    whole = first[first + length <= len(error)]
    return np.asarray(error[whole[:, None] + np.arange(length)])


def _right_again_s(
    courses: Sequence[Course], sent_at: Sequence[Ticks], reckoning: str, loss: float, rng: np.random.Generator
) -> float:
    """Longest time from the end of a loss until the error stays below the limit, s."""
    longest_s = 0.0
    for course, ticks in zip(courses, sent_at, strict=True):
        rate_hz, seconds = course.rate_hz, len(ticks) / course.rate_hz
        for cut_s in np.arange(_CUT_EVERY_S, seconds - _AFTER_S, _CUT_EVERY_S).tolist():
            part = slice(round((cut_s - _BEFORE_S) * rate_hz), round((cut_s + _AFTER_S) * rate_hz))
            before = round(_BEFORE_S * rate_hz)
            arrives = ticks[part].copy()
            arrives[:before] = kept(arrives[:before], loss, rng)
            arrives[0] = True
            shown = Course(course.name, rate_hz, course.place_m[part])
            off = np.flatnonzero(error_m(shown, reckoning, arrives)[before:] > LIMIT_M)
            longest_s = max(longest_s, (off[-1] + 1) / rate_hz if off.size else 0.0)
    return longest_s


def _runs(above: NDArray[np.bool_]) -> list[int]:
    """Length of each stretch of True."""
    return [sum(1 for _ in run) for is_above, run in groupby(above.tolist()) if is_above]


def _share(sent_at: Sequence[Ticks]) -> float:
    return float(sum(map(np.count_nonzero, sent_at)) / sum(map(len, sent_at)))
