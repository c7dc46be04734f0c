"""Calibrating the surface table from labelled strokes."""

import math
from pathlib import Path

import numpy as np

from common.messages import ExplorationMode
from remote_site.stroke_segment import Segment
from remote_site.stroke_segments import segments
from remote_site.surface_class import NOMINAL_FORCE_N, NOMINAL_SPEED_M_S, Surface, SurfaceTable
from remote_site.traces import read_labels, read_stroke

LEAST_SD = 0.08
"""Standard deviation of ln(roughness) of a surface, at least."""
LEAST_SPREAD = 0.2
"""Force and speed exponents are fitted where ln(force), ln(speed) vary by this within surfaces."""
PATTERNED = 0.5
"""A surface is patterned when more than this part of its strokes shows a period."""
SMOOTH, ROUGH = (math.log(0.010), 1500.0, 45.0), (math.log(0.25), 5000.0, 120.0)
"""ln(roughness), K_v,s and K_F,s of a smooth and a rough surface: the heuristic scale between."""


def calibrate_texture(
    folder: Path,
    out: Path,
    *,
    constants: dict[str, tuple[float, float]] | None = None,
    sensor_serial: str = "unknown",
    made_on: str = "",
) -> SurfaceTable:
    """Make a surface table from FOLDER/labels.csv (`file,surface`) and write it to `out`.

    Args:
        folder: holds labels.csv and the strokes it names.
        out: file to write.
        constants: K_v,s in (rad/s)/(m/s) and K_F,s in (rad/s)/N of surfaces that have values of their
            own; the others get theirs from a scale of roughness.
        sensor_serial: the sensor that recorded them.
        made_on: ISO date.

    Raises:
        ValueError: a file cannot be used; names file, line and column.
    """
    strokes: dict[str, list[Segment]] = {}
    for path, label, _ in read_labels(folder, "surface"):
        parts = [p for p in segments(read_stroke(path)) if p.mode is ExplorationMode.STROKING]
        parts = [p for p in parts if p.roughness_v is not None and p.roughness_v > 0.0]
        if not parts:
            raise ValueError(f"{path}: no stroke in it: column force_n or speed_mm_s never says so for 0.1 s")
        strokes.setdefault(label, []).append(max(parts, key=lambda p: p.end_s - p.start_s))
    force, speed = _exponents(strokes)
    table = SurfaceTable(force_exponent=force, speed_exponent=speed, surfaces=[_UNSET], sensor_serial=sensor_serial)
    surfaces = [_surface(label, own, table, (constants or {}).get(label)) for label, own in strokes.items()]
    table = table.model_copy(update={"surfaces": surfaces, "made_on": made_on})
    table.save(out)
    return table


_UNSET = Surface(name="unset", ln_roughness=0.0, ln_roughness_sd=1.0, k_stroke_v=1.0, k_stroke_f=1.0)


def _exponents(strokes: dict[str, list[Segment]]) -> tuple[float, float]:
    """Exponents of force and speed, from how roughness varies within each surface."""
    rows, values = [], []
    for own in strokes.values():
        x = np.array([[_ln(s.force_n, NOMINAL_FORCE_N), _ln(s.speed_m_s, NOMINAL_SPEED_M_S)] for s in own])
        y = np.array([math.log(s.roughness_v or 1e-4) for s in own])
        rows.append(x - x.mean(axis=0))
        values.append(y - y.mean())
    x, y = np.concatenate(rows), np.concatenate(values)
    exponents = [
        SurfaceTable.model_fields["force_exponent"].default,
        SurfaceTable.model_fields["speed_exponent"].default,
    ]
    varied = [k for k in (0, 1) if x[:, k].std() > LEAST_SPREAD]
    fixed = [k for k in (0, 1) if k not in varied]
    if varied:
        rest = y - x[:, fixed] @ np.array([exponents[k] for k in fixed])
        for k, value in zip(varied, np.linalg.lstsq(x[:, varied], rest, rcond=None)[0], strict=True):
            exponents[k] = float(np.clip(value, 0.0, 2.0))
    return exponents[0], exponents[1]


def _ln(value: float | None, nominal: float) -> float:
    return 0.0 if value is None else math.log(max(value, 1e-3) / nominal)


def _surface(label: str, own: list[Segment], table: SurfaceTable, constants: tuple[float, float] | None) -> Surface:
    """One surface's row of the table."""
    ln_roughness = [table.ln_normal(s.roughness_v or 1e-4, s.force_n, s.speed_m_s) for s in own]
    # by ranks: one stroke over a grating that was taken for roughness must not widen the class
    centre = float(np.median(ln_roughness))
    spread = 1.4826 * float(np.median(np.abs(np.array(ln_roughness) - centre)))
    periods = [s.period for s in own if s.period is not None]
    patterned = len(periods) > PATTERNED * len(own)
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
