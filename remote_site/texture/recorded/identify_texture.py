"""Identifies the texture of recorded strokes off line, with one JSON line for each segment."""

import math
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from common.files.read_files import read_json
from common.runtime.parallel_map import Progress, in_order, unseen
from remote_site.texture.recorded.spectrum_table import Recognised, SpectrumTable
from remote_site.texture.recorded.stroke_playback import FAST_HZ
from remote_site.texture.recorded.stroke_segment import Segment
from remote_site.texture.recorded.stroke_segments import segments
from remote_site.texture.surface_table import StrokeLaw, SurfaceTable
from remote_site.texture.texture_law import ln_roughness
from remote_site.traces.trace_files import StrokeTrace, read_stroke
from remote_site.traces.units import wrong_speeds

RPM_PER_MM_S = 60.0 / (2.0 * math.pi) / 1000.0
"""Factor from (rad/s)/(m/s) to rpm/(mm/s)."""
RPM = 60.0 / (2.0 * math.pi)
"""Factor from rad/s to rpm."""
SHIPPED = Path(__file__).parents[2] / "tables" / "surfaces.json"
"""Table whose sensor law is used when no table is given."""


def load_surfaces(path: Path) -> SurfaceTable | SpectrumTable:
    """Read a table of surfaces, either of a texture sensor or of slow strokes.

    Raises:
        ValueError: the file is neither, or was changed.
    """
    try:
        kind = read_json(path).get("kind")
    except (OSError, ValueError, AttributeError):
        kind = None
    return SpectrumTable.load(path) if kind == "surface_spectra" else SurfaceTable.load(path)


def identify_texture(
    strokes: Sequence[Path],
    table: SurfaceTable | SpectrumTable | None = None,
    signal: str | None = None,
    speed_mm_s: float | None = None,
    processes: int = 1,
    progress: Progress = unseen,
) -> Iterator[dict[str, Any]]:
    """Yield one line per segment in contact of every stroke; `null` marks values that could not be determined.

    Args:
        strokes: trace files.
        table: sensor and calibrated surfaces. Without one, lines have neither a surface nor constants, and the shipped
            table gives the law of the sensor. With a table of slow strokes, lines have a surface, or `unknown`, with
            its probability among the calibrated ones, and no constants.
        signal: column, `best` or `mean`; see `read_stroke`.
        speed_mm_s: speed of recordings without a speed column, mm/s.
        processes: number of processes that share the work; the lines do not depend on it.
        progress: is called with the completed share, 0..1.

    Raises:
        ValueError: a file cannot be used (the message names file, line and column), or the speed is not positive.
    """
    if speed_mm_s is not None and not 0.0 < speed_mm_s < 10_000.0:
        raise ValueError(f"--speed: must be positive, mm/s, not {speed_mm_s}")
    if speed_mm_s is not None and (why := wrong_speeds(np.array([speed_mm_s]))):
        raise ValueError(f"--speed: {why}")
    speed_m_s = None if speed_mm_s is None else speed_mm_s / 1000.0
    for lines in in_order(partial(_lines, table, signal, speed_m_s), strokes, processes, progress):
        yield from lines


def _lines(
    table: SurfaceTable | SpectrumTable | None, signal: str | None, speed_m_s: float | None, path: Path
) -> list[dict[str, Any]]:
    """Return the lines of one stroke."""
    surfaces = table if isinstance(table, SurfaceTable) else SurfaceTable.load(SHIPPED)
    trace, lines = read_stroke(path, signal), []
    for part in segments(trace, surfaces, speed_m_s):
        line = _line(path, part, table if isinstance(table, SurfaceTable) else None)
        if isinstance(table, SpectrumTable):
            whole = read_stroke(path, "best") if signal == "mean" else trace
            found = _recognised(path, whole, table, speed_m_s)
            line["surface"] = None if found is None else found.surface
            line["surface_probability"] = None if found is None else round(found.probability, 4)
        lines.append(line)
    return lines


def _recognised(path: Path, trace: StrokeTrace, table: SpectrumTable, speed_m_s: float | None) -> Recognised | None:
    if trace.rate_hz >= FAST_HZ:
        raise ValueError(f"{path}: {trace.rate_hz:.0f} samples/s; the table is of strokes below {FAST_HZ:.0f}")
    return table.recognise(trace, speed_m_s)


def _line(path: Path, part: Segment, table: SurfaceTable | None) -> dict[str, Any]:
    """Return a segment as a line of output."""
    line: dict[str, Any] = {
        "stroke": str(path),
        "mode": part.mode.name.lower(),
        "start_s": round(part.start_s, 4),
        "end_s": round(part.end_s, 4),
        "surface": None,
        "roughness_v": None if part.roughness_v is None else round(part.roughness_v, 5),
        "k_speed_rpm_per_mm_s": None,
        "k_force_rpm_per_n": None,
        "impulses_s": part.impulses_s,
        "period_mm": None,
        "period_sd_mm": None,
        "irregular": None if part.period is None else part.period.irregular,
        "changed": part.changed,
        "fault": part.fault,
    }
    if part.period is not None and not part.period.irregular:
        line["period_mm"] = round(1000.0 * part.period.period_m, 3)
        line["period_sd_mm"] = round(1000.0 * part.period.period_sd_m, 3)
    if table is not None and part.surface is not None and part.roughness_v is not None:
        constants = StrokeLaw(table).at(ln_roughness(part.roughness_v))
        line["surface"] = part.surface
        line["k_speed_rpm_per_mm_s"] = round(constants.k_stroke_v * RPM_PER_MM_S, 3)
        line["k_force_rpm_per_n"] = round(constants.k_stroke_f * RPM, 2)
    return line
