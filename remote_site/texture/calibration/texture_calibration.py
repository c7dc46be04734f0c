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
from remote_site.texture.texture_law import TextureLaw, ln_roughness
from remote_site.traces.trace_files import read_labels, read_stroke
from remote_site.traces.units import stated_speed_m_s

LEAST_SD = 0.08
"""Minimum standard deviation of ln(roughness) of a surface."""
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
    """Make a surface table from FOLDER/labels.csv (`file,surface[,roughness_um]`) and write it to `out`.

    Args:
        folder: holds labels.csv and the strokes it names.
        out: file to write.
        signal: column, `best` or `mean`; see `read_stroke`.
        speed_mm_s: speed of recordings without a speed column, mm/s.
        constants: K_v,s in (rad/s)/(m/s) and K_F,s in (rad/s)/N of surfaces with values of their own; the others get
            theirs from a scale of roughness.
        sensor_serial: serial number of the sensor that recorded the strokes.
        made_on: ISO date of the calibration.

    Raises:
        ValueError: a file cannot be used (the message names file, line and column), or the speed cannot be one.
    """
    labelled, stated_m_s = [], stated_speed_m_s(speed_mm_s)
    for path, label, roughness_um in read_labels(folder, "surface", "roughness_um"):
        trace = read_stroke(path, signal)
        if trace.rate_hz < FAST_HZ:
            raise ValueError(f"{path}: recorded at {trace.rate_hz:.0f} Hz; single grooves need {FAST_HZ:.0f} Hz")
        labelled.append(LabelledStroke(str(path), label, even_stroke(trace, stated_m_s), roughness_um))
    fit = fit_surfaces(labelled, constants or {})
    table = fit.table.model_copy(update={"sensor_serial": sensor_serial, "made_on": made_on})
    table.save(out)
    return replace(fit, table=table)


def fit_surfaces(labelled: Sequence[LabelledStroke], constants: dict[str, tuple[float, float]]) -> TextureFit:
    """Fit law and surfaces to strokes; `constants` and errors as in `calibrate_texture`."""
    labelled = sorted(labelled, key=lambda one: one.surface)
    law = fit_law(labelled)
    found = [_longest(one, law.law) for one in labelled]
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
        [*_missing(law), *_one_stroke(own), *_confused(taken_for)],
    )


def _longest(one: LabelledStroke, law: TextureLaw) -> Segment:
    """Return the longest stroking part of a stroke; it has one label, so a change of surface within it is ignored."""
    found = even_segments(one.stroke, anything(law))
    parts = [p for p in found if p.mode is ExplorationMode.STROKING and p.roughness_v is not None]
    if not parts and (fault := next((p.fault for p in found if p.fault is not None), None)) is not None:
        raise ValueError(f"{one.file}: {fault}; leave this stroke out")
    if not parts:
        raise ValueError(f"{one.file}: no stroke: columns force_n and speed_mm_s never show stroking for 0.1 s")
    return max(parts, key=lambda p: p.end_s - p.start_s)


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
