"""Identifies the stiffness of recorded presses off line, with one JSON line for each press."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from common.wire.messages import STIFFNESS_KNOWN_LN_SD
from remote_site.stiffness.force_law import gradient
from remote_site.stiffness.press_population import Fits, fit_presses
from remote_site.stiffness.press_priors import CONTACT_ODDS, OTHER_CONTACTS, OTHER_LAWS
from remote_site.stiffness.recorded.averaged_priors import OtherFits, Stated, averaged
from remote_site.traces.press_files import Press, read_presses, require_own_contacts
from remote_site.traces.trace_files import require_all

Array = NDArray[np.float64]

AT_N = 1.0
"""Force at which the stiffness is stated, N."""
LEAST_SAMPLES, LEAST_STATED = 3, 2
"""Smallest number of samples of a press, and of one whose contact the recording states."""
LEAST_DEPTH_MM = 0.05
"""Smallest range of the depths of a press, mm."""
LEAST_RISE_SD = 3.0
"""Smallest slope of force over depth of a contact, in standard deviations."""
AIR_N = 0.02
"""Largest force of a sample in the air, N."""
PRESSED_N = 0.1
"""Force by which a contact has certainly begun, N."""
AIR_SAMPLES = 3
"""Number of samples in the air from which the first contact is sought between samples."""
PRELOAD_SHARE = 0.3
"""First force, as a fraction of the deepest one, from which a press began below the first contact.

A robot's contact is at 0.05 to 0.1 N.
"""
MOST_BLOCKS = 40
"""Number of means that represent a press of more samples."""
MODEL_TO, MODEL_POINTS = 1.5, 45
"""Depth to which the law is stated, as a multiple of the deepest sample, and number of its even depths."""
MOST_MISFIT = 3.0
"""Largest misfit of a known stiffness, in standard deviations."""
MOST_LN_SD = 1.0
"""Largest standard deviation of ln stiffness where the recording states no contact."""


class Model(TypedDict):
    """Law of one press at all its depths and beyond.

    Attributes:
        depth_mm: depths, mm, ascending, to 1.5 times the deepest.
        force_n: forces of the law, N.
        force_sd_n: their standard deviations, N.
    """

    depth_mm: list[float]
    force_n: list[float]
    force_sd_n: list[float]


class StiffnessAnswer(TypedDict):
    """Answer about one press; None for what could not be determined.

    Attributes:
        press: number of the press.
        status: `known`, `uncertain` or `failed`.
        reason: why the press failed.
        stiffness_n_m: force over depth below the first contact, at the force `at_n`, N/m. Times `exponent` it is the
            slope of the force there.
        stiffness_sd_n_m: standard deviation of its error, N/m, with what all presses of the object share: the law, and
            a contact that the recording does not state.
        stiffness_repeat_sd_n_m: standard deviation of what differs between presses of the object, N/m.
        at_n: force at which it is stated, N.
        exponent: d ln F / d ln depth at `at_n`; 1 for a spring, 1.5 for a sphere on an elastic body (Hertz).
        exponent_sd: its standard deviation.
        contact_depth_mm: depth of the first contact, mm.
        model: law at all depths.
        misfit: root mean square residual, in standard deviations.
    """

    press: int
    status: str
    reason: str | None
    stiffness_n_m: float | None
    stiffness_sd_n_m: float | None
    stiffness_repeat_sd_n_m: float | None
    at_n: float
    exponent: float | None
    exponent_sd: float | None
    contact_depth_mm: float | None
    model: Model | None
    misfit: float | None


@dataclass(frozen=True, slots=True)
class _Onset:
    """Place of first contact of a press before its fit: depth, mm, and standard deviation, mm."""

    depth_mm: float
    sd_mm: float


def identify_stiffness(files: Sequence[Path]) -> Iterator[dict[str, Any]]:
    """Yield one line per press of every file; the presses of one file are of one object.

    Raises:
        ValueError: after all lines: a file cannot be used; the message names file, line and column.
    """
    owners: dict[tuple[Path, int], Path] = {}
    wrong: list[str] = []
    for path in files:
        try:
            presses = read_presses(path)
            require_own_contacts(path, presses, owners)
        except ValueError as error:
            wrong.append(str(error))
            continue
        for answer in identify_presses(presses):
            yield {"file": str(path), **answer}
    require_all(wrong, len(files))


def identify_presses(presses: Sequence[Press], at_n: float = AT_N) -> list[StiffnessAnswer]:
    """Return one answer per press of one object.

    The presses of other places are the prior of each, so that a press alone has a larger uncertainty.

    Args:
        presses: the presses, in any order; those of one object go together.
        at_n: force at which the stiffness is stated, N.

    Raises:
        ValueError: the force is not positive.
    """
    if not 0.0 < at_n < np.inf:
        raise ValueError(f"at_n: must be positive, N, not {at_n}")
    reasons = [_unusable(press) for press in presses]
    usable = [press for press, reason in zip(presses, reasons, strict=True) if reason is None]
    found = iter(_fitted(usable, at_n) if usable else [])
    return [
        next(found) if reason is None else _failed(press.press, at_n, reason)
        for press, reason in zip(presses, reasons, strict=True)
    ]


def _unusable(press: Press) -> str | None:
    """Return why a press gives no stiffness, or None; a contact that the recording states is not doubted."""
    status = None if press.contact is None else press.contact.status
    if status == "fail":
        return "the recording states that the press failed"
    least = LEAST_SAMPLES if status is None else LEAST_STATED
    if len(press.depth_mm) < least:
        return f"{len(press.depth_mm)} samples; {least} are needed"
    if np.ptp(press.depth_mm) < LEAST_DEPTH_MM:
        return f"the depth changes by less than {LEAST_DEPTH_MM:g} mm"
    if status is None and (press.force_n.max() <= AIR_N or _rise_sd(press) < LEAST_RISE_SD):
        return "no contact: the force does not rise with depth"
    return None


def _rise_sd(press: Press) -> float:
    """Return the slope of force over depth, in standard deviations."""
    if not np.ptp(press.force_n):
        return 0.0
    share = float(np.corrcoef(press.depth_mm, press.force_n)[0, 1])
    return share * float(np.sqrt((len(press.force_n) - 2) / max(1e-12, 1.0 - share * share)))


def _failed(press: int, at_n: float, reason: str) -> StiffnessAnswer:
    return {
        "press": press,
        "status": "failed",
        "reason": reason,
        "stiffness_n_m": None,
        "stiffness_sd_n_m": None,
        "stiffness_repeat_sd_n_m": None,
        "at_n": at_n,
        "exponent": None,
        "exponent_sd": None,
        "contact_depth_mm": None,
        "model": None,
        "misfit": None,
    }


def _fitted(presses: Sequence[Press], at_n: float) -> list[StiffnessAnswer]:
    """Return the answers about usable presses of one object."""
    onsets = [_onset(press) for press in presses]
    blocks = [_blocks(press) for press in presses]
    longest = max(len(depth_mm) for depth_mm, _ in blocks)
    depth_mm, force_n, weight = np.zeros((3, len(presses), longest))
    for k, (onset, (depths, forces)) in enumerate(zip(onsets, blocks, strict=True)):
        depth_mm[k, : len(depths)], force_n[k, : len(depths)] = depths - onset.depth_mm, forces
        weight[k, : len(depths)] = 1.0
    contact_sd_mm = np.array([onset.sd_mm for onset in onsets])
    fits = fit_presses(depth_mm, force_n, weight, contact_sd_mm)
    every = np.ones(len(presses), dtype=bool)
    # Only a contact that is neither stated, nor found after air, nor below a preload, is assumed at the first sample.
    assumed = np.array([press.contact is None for press in presses]) & (contact_sd_mm == 0.0)
    priors = [(law, every, 1.0) for law in OTHER_LAWS]
    priors += [(touch, assumed, CONTACT_ODDS) for touch in OTHER_CONTACTS]
    others = [
        OtherFits(fit_presses(depth_mm[holds], force_n[holds], weight[holds], contact_sd_mm[holds], prior), holds, odds)
        for prior, holds, odds in priors
        if holds.any()
    ]
    stated = averaged(fits, others, at_n)
    return [
        _answer(press, onset, fits, k, stated, at_n)
        for k, (press, onset) in enumerate(zip(presses, onsets, strict=True))
    ]


def _onset(press: Press) -> _Onset:
    """Return the place of first contact: after samples in the air, else about the first sample."""
    order = np.argsort(press.depth_mm, kind="stable")
    depth_mm, force_n = press.depth_mm[order], press.force_n[order]
    air = _rises_above(force_n, AIR_N)
    if AIR_SAMPLES <= air < len(force_n):
        pressed = min(_rises_above(force_n, PRESSED_N), len(force_n) - 1)
        return _Onset(float(depth_mm[air - 1]), float(depth_mm[max(pressed, air)] - depth_mm[air - 1]))
    preload_n, rise_n = float(force_n[0] - PRELOAD_SHARE * force_n[-1]), float(force_n[-1] - force_n[0])
    if preload_n <= 0.0 or rise_n <= 0.0:
        return _Onset(float(depth_mm[0]), 0.0)
    above_mm = min(1.0, preload_n / rise_n) * float(depth_mm[-1] - depth_mm[0])
    return _Onset(float(depth_mm[0]) - above_mm, above_mm)


def _rises_above(force_n: Array, limit_n: float) -> int:
    """Return the number of forces before the rise above a limit: the split that most forces agree with."""
    above = np.concatenate(([0], np.cumsum(np.where(force_n > limit_n, 1, -1))))
    return int(above.argmin())


def _blocks(press: Press) -> tuple[Array, Array]:
    """Return depths, mm, and forces, N, or their means over MOST_BLOCKS parts of a longer press."""
    if len(press.depth_mm) <= MOST_BLOCKS:
        return press.depth_mm, press.force_n
    return tuple(  # type: ignore[return-value]
        np.array([part.mean() for part in np.array_split(values, MOST_BLOCKS)])
        for values in (press.depth_mm, press.force_n)
    )


def _answer(press: Press, onset: _Onset, fits: Fits, k: int, stated: Stated, at_n: float) -> StiffnessAnswer:
    """Return the answer of press k of the fits."""
    misfit = float(fits.misfit[k])
    ln_n_m, exponent, contact_mm = stated.values[k].tolist()
    ln_sd, exponent_sd, _ = stated.sd[k].tolist()
    repeat_ln_sd = float(stated.repeat_sd[k, 0])
    if not np.isfinite(stated.sd[k]).all() or (press.contact is None and ln_sd > MOST_LN_SD):
        return _failed(press.press, at_n, "the samples do not determine the stiffness")
    stiffness_n_m = float(np.exp(ln_n_m))
    reached = contact_mm + 1000.0 * at_n / stiffness_n_m <= MODEL_TO * float(press.depth_mm.max() - onset.depth_mm)
    known = reached and repeat_ln_sd < STIFFNESS_KNOWN_LN_SD and misfit < MOST_MISFIT
    return {
        "press": press.press,
        "status": "known" if known else "uncertain",
        "reason": None,
        "stiffness_n_m": _rounded(stiffness_n_m),
        "stiffness_sd_n_m": _rounded(stiffness_n_m * ln_sd),
        "stiffness_repeat_sd_n_m": _rounded(stiffness_n_m * repeat_ln_sd),
        "at_n": at_n,
        "exponent": round(exponent, 4),
        "exponent_sd": round(exponent_sd, 4),
        "contact_depth_mm": round(onset.depth_mm + contact_mm, 4),
        "model": _model(press, onset, fits, k),
        "misfit": round(misfit, 3),
    }


def _rounded(value: float) -> float:
    """Return a positive number with two decimals, or with three digits below 1: none becomes 0."""
    return round(value, 2) if value >= 1.0 else float(f"{value:.3g}")


def _model(press: Press, onset: _Onset, fits: Fits, k: int) -> Model:
    """Return the law of press k at its depths, or at even ones of a long press, and to MODEL_TO times the deepest."""
    deepest_mm = float(press.depth_mm.max())
    to_mm = max(deepest_mm, MODEL_TO * deepest_mm)
    even_mm = np.linspace(float(press.depth_mm.min()), to_mm, MODEL_POINTS)
    own_mm = press.depth_mm if len(press.depth_mm) <= MOST_BLOCKS else np.empty(0)
    depth_mm = np.unique(np.round(np.concatenate([even_mm, own_mm]), 4))
    u = ((depth_mm - onset.depth_mm) / fits.unit_mm)[np.newaxis]
    law_n, by, _ = gradient(fits.parameters[k : k + 1], u)
    variance = np.einsum("mi,ij,mj->m", by[0], fits.covariance[k] + fits.common[k], by[0])
    elastic_n = law_n[0] - fits.parameters[k, 4]
    sd_n = fits.scale[k] * np.sqrt(variance + (fits.errors.share * elastic_n) ** 2)
    return {
        "depth_mm": depth_mm.tolist(),
        "force_n": np.round(law_n[0], 5).tolist(),
        "force_sd_n": np.round(sd_n, 5).tolist(),
    }
