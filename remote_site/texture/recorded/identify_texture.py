"""Identifies the texture of recorded strokes off line, with one JSON line for each segment."""

import logging
import math
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NotRequired, TypedDict

from common.files.printable import printable
from common.files.read_files import read_json
from common.runtime.parallel_map import Progress, in_order, unseen
from remote_site.texture.motion_spectrum import UNKNOWN, MotionSpectra
from remote_site.texture.recorded.spectrum_table import Recognised, SpectrumTable
from remote_site.texture.recorded.stroke_playback import FAST_HZ
from remote_site.texture.recorded.stroke_segments import Segment, segments
from remote_site.texture.surface_table import StrokeLaw, SurfaceTable
from remote_site.texture.texture_law import ln_roughness
from remote_site.traces.trace_files import StrokeTrace, read_stroke, require_all
from remote_site.traces.units import stated_speed_m_s

log = logging.getLogger(__name__)

RPM_PER_MM_S = 60.0 / (2.0 * math.pi) / 1000.0
"""Factor from (rad/s)/(m/s) to rpm/(mm/s)."""
RPM = 60.0 / (2.0 * math.pi)
"""Factor from rad/s to rpm."""
SHIPPED = Path(__file__).parents[2] / "tables" / "surfaces.json"
"""Table whose sensor law is used when no table is given."""


class SurfaceAnswer(TypedDict):
    """Answer about one segment of a stroke; None for what could not be determined.

    Attributes:
        mode: `tapping`, `quiescent` or `stroking`.
        start_s: begin of the segment, s.
        end_s: end of the segment, s.
        surface: likeliest calibrated surface; with a table that has spectra, `unknown` if none fits.
        surface_probability: its probability, 0..1, with a table of spectra.
        roughness_v: roughness without grooves, V or the signal's own unit.
        roughness_um: roughness, um, with a table calibrated for it; None outside of the calibrated range.
        roughness_sd_um: its standard deviation, um.
        k_speed_rpm_per_mm_s: motor speed for each mm/s of stroke speed, rpm/(mm/s) (Kron & Schmidt 2003, Eq. 2).
        k_force_rpm_per_n: motor speed for each newton, rpm/N.
        impulses_s: times of grooves and edges, s.
        period_mm: distance of the grooves, mm.
        period_sd_mm: its standard deviation, mm; an error of the speed counts where its deviation is known.
        irregular: whether there are grooves without a period.
        changed: whether the segment begins where the stroke reached another surface.
        fault: fault of the sensor.
    """

    mode: str
    start_s: float
    end_s: float
    surface: str | None
    surface_probability: NotRequired[float | None]
    roughness_v: float | None
    roughness_um: NotRequired[float | None]
    roughness_sd_um: NotRequired[float | None]
    k_speed_rpm_per_mm_s: float | None
    k_force_rpm_per_n: float | None
    impulses_s: list[float]
    period_mm: float | None
    period_sd_mm: float | None
    irregular: bool | None
    changed: bool
    fault: str | None


def load_surfaces(path: Path | str) -> SurfaceTable | SpectrumTable:
    """Read a table of surfaces, either of a texture sensor or of slow strokes.

    Raises:
        ValueError: the file is neither, or was changed.
    """
    try:
        kind = read_json(Path(path)).get("kind")
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
    speed_sd_mm_s: float = 0.0,
) -> Iterator[dict[str, Any]]:
    """Yield one line per segment in contact of every stroke; `null` marks values that could not be determined.

    A warning is logged for a stroke without a line.

    Args:
        strokes: trace files.
        table: sensor and calibrated surfaces. Without one, lines have neither a surface nor constants, and the shipped
            table gives the law of the sensor. With a table of slow strokes, lines have a surface, or `unknown`, with
            its probability among the calibrated ones, and no constants.
        signal: column, `best` or `mean`; see `read_stroke`.
        speed_mm_s: speed of recordings without a speed column, mm/s.
        processes: number of processes that share the work; the lines do not depend on it.
        progress: is called with the completed share, 0..1.
        speed_sd_mm_s: standard deviation of a constant error of the speed, mm/s; it widens that of the period.

    Raises:
        ValueError: the speed is not positive, or its deviation is negative. After all lines: a file cannot be used (the
            message names file, line and column).
    """
    if not 0.0 <= speed_sd_mm_s < 10_000.0:
        raise ValueError(f"--speed-sd: must be 0 or more, mm/s, not {speed_sd_mm_s}")
    one = partial(_lines, table, signal, stated_speed_m_s(speed_mm_s), speed_sd_mm_s / 1000.0)
    wrong: list[str] = []
    for lines, error in in_order(one, strokes, processes, progress):
        yield from lines
        wrong += error
    require_all(wrong, len(strokes))


def _lines(
    table: SurfaceTable | SpectrumTable | None,
    signal: str | None,
    speed_m_s: float | None,
    speed_sd_m_s: float,
    path: Path,
) -> tuple[list[dict[str, Any]], list[str]]:
    """Return the lines of one stroke, or what is wrong with its file."""
    try:
        trace = read_stroke(path, signal)
        whole = read_stroke(path, "best") if signal == "mean" else None
        answers = identify_stroke(trace, table, speed_m_s, whole, speed_sd_m_s)
    except ValueError as error:
        return [], [str(error)]
    if not answers:
        log.warning("%s: no answer: force_n never shows contact, or the stroke is too short", printable(str(path)))
    return [{"stroke": str(path), **answer} for answer in answers], []


def identify_stroke(
    trace: StrokeTrace,
    table: SurfaceTable | SpectrumTable | None = None,
    speed_m_s: float | None = None,
    whole: StrokeTrace | None = None,
    speed_sd_m_s: float = 0.0,
) -> list[SurfaceAnswer]:
    """Return one answer per segment in contact of a stroke.

    Args:
        trace: the stroke.
        table: sensor and calibrated surfaces, as for `identify_texture`.
        speed_m_s: speed of a stroke without one, m/s.
        whole: all signals of the stroke, where `trace` has their mean; by default those of `trace`.
        speed_sd_m_s: standard deviation of a constant error of the speed, m/s.

    Raises:
        ValueError: the table is of another kind of stroke or of another sensor.
    """
    if isinstance(table, SurfaceTable) and trace.rate_hz < FAST_HZ:
        raise ValueError(
            f"{trace.name}: {trace.rate_hz:.0f} samples/s; the table is of strokes of {FAST_HZ:.0f} or more: leave "
            "it out, or calibrate such strokes"
        )
    surfaces = table if isinstance(table, SurfaceTable) else SurfaceTable.load(SHIPPED)
    answers = []
    for part in segments(trace, surfaces, speed_m_s, whole):
        answer = _answer(part, table if isinstance(table, SurfaceTable) else None, speed_sd_m_s)
        if isinstance(table, SpectrumTable):
            found = _recognised(whole or trace, table, speed_m_s)
            answer["surface"] = None if found is None else found.surface
            answer["surface_probability"] = None if found is None else round(found.probability, 4)
        answers.append(answer)
    return answers


def _recognised(trace: StrokeTrace, table: SpectrumTable, speed_m_s: float | None) -> Recognised | None:
    if trace.rate_hz >= FAST_HZ:
        raise ValueError(f"{trace.name}: {trace.rate_hz:.0f} samples/s; the table is of strokes below {FAST_HZ:.0f}")
    return table.recognise(trace, speed_m_s)


def _answer(part: Segment, table: SurfaceTable | None, speed_sd_m_s: float) -> SurfaceAnswer:
    answer: SurfaceAnswer = {
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
        answer["period_mm"] = round(1000.0 * part.period.period_m, 3)
        of_speed = part.period.period_m * speed_sd_m_s / abs(part.speed_m_s) if part.speed_m_s else 0.0
        answer["period_sd_mm"] = round(1000.0 * math.hypot(part.period.period_sd_m, of_speed), 3)
    if table is not None and part.surface is not None and part.roughness_v is not None:
        constants = StrokeLaw(table).at(ln_roughness(part.roughness_v))
        answer["surface"] = part.surface
        if table.spectra is not None:
            _name_by_spectrum(answer, part, table, table.spectra)
        answer["k_speed_rpm_per_mm_s"] = round(constants.k_stroke_v * RPM_PER_MM_S, 3)
        answer["k_force_rpm_per_n"] = round(constants.k_stroke_f * RPM, 2)
    if table is not None and table.roughness_scale is not None:
        found = None if part.roughness_v is None else table.roughness_scale.at(part.roughness_v)
        answer["roughness_um"] = answer["roughness_sd_um"] = None
        if found is not None:
            answer["roughness_um"], answer["roughness_sd_um"] = round(found[0], 3), round(found[1], 3)
    return answer


def _name_by_spectrum(answer: SurfaceAnswer, part: Segment, table: SurfaceTable, spectra: MotionSpectra) -> None:
    """Set the surface, or `unknown`, and its probability; a stroke too short for a spectrum has neither."""
    answer["surface"] = answer["surface_probability"] = None
    if part.spectrum is not None:
        ranking = spectra.rank(part.spectrum)
        answer["surface"] = table.surfaces[ranking.best].name if ranking.known else UNKNOWN
        answer["surface_probability"] = round(float(ranking.probabilities.max()), 4)
