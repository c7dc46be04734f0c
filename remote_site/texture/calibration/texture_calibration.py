"""Calibrates the surface table from labelled strokes."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

import numpy as np

from common.wire.messages import ExplorationMode
from remote_site.texture.calibration.law_fit import LabelledStroke, LawFit, anything, fit_law
from remote_site.texture.calibration.motion_spectrum_fit import MotionFit, fit_spectra
from remote_site.texture.calibration.roughness_fit import KnownRoughness, fit_scale
from remote_site.texture.recorded.stroke_playback import FAST_HZ, EvenStroke, even_stroke
from remote_site.texture.recorded.stroke_segments import Segment, even_segments
from remote_site.texture.surface_table import Surface, SurfaceTable
from remote_site.texture.texture_law import NOMINAL_FORCE_N, NOMINAL_SPEED_M_S, TextureLaw, ln_roughness
from remote_site.traces.trace_files import read_labels, read_stroke
from remote_site.traces.units import stated_speed_m_s

LEAST_SD = 0.08
"""Minimum standard deviation of ln(roughness) of a surface."""
UNLIKE = math.log(3.0)
"""Difference of ln(roughness) of strokes with one label above which one of them is on another surface."""
PATTERNED = 0.5
"""Fraction of a surface's strokes with a period above which the surface is patterned."""
DISTINGUISHED = 0.9
"""Minimum fraction of each surface's strokes that are not taken for the other one if both are distinguished."""
SMOOTH, ROUGH = (math.log(0.003), 1500.0, 45.0), (math.log(0.17), 5000.0, 120.0)
"""ln(roughness in V), K_v,s, (rad/s)/(m/s), and K_F,s, (rad/s)/N, at the ends of a heuristic scale of roughness."""


@dataclass(frozen=True, slots=True)
class TextureFit:
    """Result of a calibration.

    Attributes:
        table: the calibrated table.
        law: the fitted law of the sensor.
        strokes: number of strokes of each surface.
        scatter: standard deviation over mean of the roughness of each surface's strokes.
        taken_for: for each true surface, the number of strokes taken for each surface by a table made without them.
            Spectra name the surfaces where the table has spectra.
        scaled: number of strokes with a known roughness in um.
        warnings: faults and missing data, one line each.
    """

    table: SurfaceTable
    law: LawFit
    strokes: dict[str, int]
    scatter: dict[str, float]
    taken_for: dict[str, dict[str, int]]
    scaled: int
    warnings: list[str]


def calibrate_texture(
    folder: Path,
    out: Path,
    *,
    signal: str | None = None,
    speed_mm_s: float | None = None,
    constants: dict[str, tuple[float, float]] | None = None,
    sensor_serial: str = "unknown",
    made_on: str = "",
) -> TextureFit:
    """Make a surface table from FOLDER/labels.csv (`file,surface[,speed_mm_s][,roughness_um]`) and write it to `out`.

    Args:
        folder: holds labels.csv and the strokes it names.
        out: file to write.
        signal: column, `best` or `mean`; see `read_stroke`.
        speed_mm_s: speed of strokes without one in the recording or in labels.csv, mm/s.
        constants: K_v,s in (rad/s)/(m/s) and K_F,s in (rad/s)/N of surfaces with values of their own; the others get
            theirs from a scale of roughness.
        sensor_serial: serial number of the sensor that recorded the strokes.
        made_on: ISO date of the calibration.

    Raises:
        ValueError: a file cannot be used (the message names file, line and column), or the speed cannot be one.
    """
    labelled, stated_m_s = [], stated_speed_m_s(speed_mm_s)
    speeds_mm_s = [own for _, _, own in read_labels(folder, "surface", "speed_mm_s")]
    listed = read_labels(folder, "surface", "roughness_um")
    for (path, label, roughness_um), own_mm_s in zip(listed, speeds_mm_s, strict=True):
        trace = read_stroke(path, signal)
        if trace.rate_hz < FAST_HZ:
            raise ValueError(
                f"{path}: {trace.rate_hz:.0f} samples/s among strokes of {FAST_HZ:.0f} or more; calibrate them apart"
            )
        speed_m_s = stated_m_s if own_mm_s is None else own_mm_s / 1000.0
        columns = {"speed_mm_s": trace.speed_m_s if speed_m_s is None else speed_m_s, "force_n": trace.force_n}
        assumed = tuple(name for name, values in columns.items() if values is None)
        labelled.append(LabelledStroke(str(path), label, even_stroke(trace, speed_m_s), roughness_um, assumed))
    fit = fit_surfaces(labelled, constants or {})
    table = fit.table.model_copy(update={"sensor_serial": sensor_serial, "made_on": made_on})
    table.save(out)
    return replace(fit, table=table)


def fit_surfaces(labelled: Sequence[LabelledStroke], constants: dict[str, tuple[float, float]]) -> TextureFit:
    """Fit law and surfaces to strokes; `constants` and errors as in `calibrate_texture`."""
    labelled = sorted(labelled, key=lambda one: one.surface)
    law = fit_law(labelled)
    parts = [_stroking(one, law.law) for one in labelled]
    found = [max(each, key=lambda part: part.end_s - part.start_s) for each in parts]
    own = {
        name: [segment for _, segment in group]
        for name, group in groupby(zip(labelled, found, strict=True), key=lambda pair: pair[0].surface)
    }
    scaled = [
        KnownRoughness(one.surface, part.roughness_v, one.roughness_um)
        for one, part in zip(labelled, found, strict=True)
        if one.roughness_um is not None and part.roughness_v is not None
    ]
    taken_for = _leave_one_out(labelled, law.law, own, constants)
    spectra = _spectra(labelled, found)
    if spectra is not None and spectra.right <= sum(taken.get(name, 0) for name, taken in taken_for.items()):
        spectra = None
    if spectra is not None:
        taken_for = {name: dict(Counter(b for a, b in spectra.left_out if a == name)) for name in own}
    table = _table(law.law, own, constants).model_copy(
        update={"roughness_scale": fit_scale(scaled), "spectra": None if spectra is None else spectra.spectra}
    )
    return TextureFit(
        table,
        law,
        {name: len(parts) for name, parts in own.items()},
        {name: _scatter(parts) for name, parts in own.items()},
        taken_for,
        len(scaled),
        [
            *_missing(law),
            *_assumed(labelled),
            *_doubtful(labelled, parts, found),
            *_one_stroke(own),
            *_confused(taken_for),
        ],
    )


def _stroking(one: LabelledStroke, law: TextureLaw) -> list[Segment]:
    """Return the stroking parts of a stroke; without a known speed they have no period.

    Raises:
        ValueError: there is none, or the sensor has a fault.
    """
    found = even_segments(one.stroke, anything(law))
    parts = [p for p in found if p.mode is ExplorationMode.STROKING and p.roughness_v is not None]
    if not parts and (fault := next((p.fault for p in found if p.fault is not None), None)) is not None:
        raise ValueError(f"{one.file}: {fault}; leave this stroke out")
    if not parts:
        raise ValueError(
            f"{one.file}: no stroke: columns force_n and speed_mm_s never show stroking for 0.1 s; check their units "
            "(N and mm/s), or leave this stroke out"
        )
    if "speed_mm_s" in one.assumed:
        for part in parts:
            part.period = None
    return parts


def _spectra(labelled: Sequence[LabelledStroke], found: Sequence[Segment]) -> MotionFit | None:
    """Return the spectra of the surfaces; None if too few strokes are long enough for one."""
    seen = [(part.spectrum, one.surface) for one, part in zip(labelled, found, strict=True) if part.spectrum]
    if len(seen) < len(labelled):
        return None
    return fit_spectra([spectrum for spectrum, _ in seen], [surface for _, surface in seen])


def _table(law: TextureLaw, own: dict[str, list[Segment]], constants: dict[str, tuple[float, float]]) -> SurfaceTable:
    surfaces = [_surface(label, parts, constants.get(label)) for label, parts in own.items()]
    patterned = [surface.name for surface in surfaces if surface.period_mm is not None]
    strengths = [strength for name in patterned for part in own[name] for strength in part.strengths_v]
    return SurfaceTable(law=law, groove_v=float(np.median(strengths)) if strengths else None, surfaces=surfaces)


def _surface(label: str, parts: Sequence[Segment], constants: tuple[float, float] | None) -> Surface:
    """Return one surface's row of the table."""
    values = [ln_roughness(part.roughness_v or 0.0) for part in parts]
    # ranks, since one stroke with a scratch or a crumb must not widen the class
    centre = float(np.median(values))
    spread = 1.4826 * float(np.median(np.abs(np.array(values) - centre)))
    periods = [part.period for part in parts if part.period is not None]
    patterned = len(periods) > PATTERNED * len(parts)
    if constants is None:
        part = float(np.clip((centre - SMOOTH[0]) / (ROUGH[0] - SMOOTH[0]), 0.0, 1.0))
        constants = (SMOOTH[1] * (ROUGH[1] / SMOOTH[1]) ** part, SMOOTH[2] * (ROUGH[2] / SMOOTH[2]) ** part)
    return Surface(
        name=label,
        ln_roughness=centre,
        ln_roughness_sd=max(spread, LEAST_SD),
        period_mm=1000.0 * float(np.median([p.period_m for p in periods])) if patterned else None,
        irregularity=float(np.median([p.irregularity for p in periods])) if patterned else 0.0,
        k_stroke_v=constants[0],
        k_stroke_f=constants[1],
    )


def _scatter(parts: Sequence[Segment]) -> float:
    values = np.array([part.roughness_v or 0.0 for part in parts])
    return float(values.std()) / max(float(values.mean()), 1e-9)


def _leave_one_out(
    labelled: Sequence[LabelledStroke],
    law: TextureLaw,
    own: dict[str, list[Segment]],
    constants: dict[str, tuple[float, float]],
) -> dict[str, dict[str, int]]:
    """Identify each stroke with surfaces fitted without it; the law belongs to the sensor and is fitted to all."""
    taken_for: dict[str, dict[str, int]] = {name: {} for name in own}
    number = dict.fromkeys(own, 0)
    for one in labelled:
        name, k = one.surface, number[one.surface]
        number[name] += 1
        others = own[name][:k] + own[name][k + 1 :]
        if others:
            found = recognised(one.stroke, _table(law, {**own, name: others}, constants))
            taken_for[name][found] = taken_for[name].get(found, 0) + 1
    return taken_for


def recognised(stroke: EvenStroke, table: SurfaceTable) -> str:
    """Return the name of the likeliest surface of the longest part of a stroke; "" without one."""
    parts = [p for p in even_segments(stroke, table) if p.surface is not None]
    return max(parts, key=lambda p: p.end_s - p.start_s).surface or "" if parts else ""


def _missing(law: LawFit) -> list[str]:
    warnings = []
    if not law.noise_known:
        warnings.append("no stroke rests in contact before it moves: the usual noise of a sensor is used")
    if not law.force_known:
        warnings.append(
            "force hardly varies within surfaces: the usual law is used; add strokes at half and twice the force"
        )
    if not law.speed_known:
        warnings.append(
            "speed hardly varies within surfaces: the usual law is used; add strokes at half and twice the speed"
        )
    return warnings


def _assumed(labelled: Sequence[LabelledStroke]) -> list[str]:
    """Return a warning for each quantity that some strokes lack."""
    speed = f"{1000.0 * NOMINAL_SPEED_M_S:g} mm/s are assumed, and the spacing of grooves is not learned from them"
    results = {
        "speed_mm_s": f"{speed}; add the column, also to labels.csv, or name --speed",
        "force_n": f"{NOMINAL_FORCE_N:g} N is assumed; add the column",
    }
    warnings = []
    for name, result in results.items():
        if lacking := [one.file for one in labelled if name in one.assumed]:
            warnings.append(f"{lacking[0]}: no {name} in {len(lacking)} of {len(labelled)} strokes: {result}")
    return warnings


def _doubtful(
    labelled: Sequence[LabelledStroke], parts: Sequence[Sequence[Segment]], found: Sequence[Segment]
) -> list[str]:
    """Return a warning for each stroke that crosses two surfaces, or is unlike the others with its label."""
    warnings = []
    values = [ln_roughness(part.roughness_v or 0.0) for part in found]
    for one, each, value in zip(labelled, parts, values, strict=True):
        others = [other for like, other in zip(labelled, values, strict=True) if like.surface == one.surface]
        away = value - float(np.median(others))
        other = (p for p in each if p.changed or abs(ln_roughness(p.roughness_v or 0.0) - value) > UNLIKE)
        # with one speed for the whole recording, a rest in it looks like another surface
        if np.ptp(one.stroke.speed_m_s) > 0.0 and (part := next(other, None)) is not None:
            warnings.append(
                f"{one.file}: the surface changes at {part.start_s:.2f} s, which makes the law of the sensor wrong; "
                "cut the recording there"
            )
        elif len(others) > 2 and abs(away) > UNLIKE:
            warnings.append(
                f"{one.file}: {math.exp(away):.2g} times as rough as most strokes of {one.surface}; check its label, "
                "or leave it out"
            )
    return warnings


def _one_stroke(own: dict[str, list[Segment]]) -> list[str]:
    warnings = [f"{name}: only one stroke: its scatter is assumed" for name, parts in own.items() if len(parts) == 1]
    if len(own) == 1:
        warnings.append(f"{next(iter(own))} is the only surface: every stroke will be named so")
    return warnings


def _confused(taken_for: dict[str, dict[str, int]]) -> list[str]:
    """Return a warning for each pair of surfaces that the strokes do not distinguish."""
    pairs = {
        tuple(sorted((true, other)))
        for true, taken in taken_for.items()
        for other, times in taken.items()
        if other != true and times > (1.0 - DISTINGUISHED) * sum(taken.values())
    }
    return [f"this sensor cannot distinguish {one} and {other}" for one, other in sorted(pairs)]
