"""Write trace files of simulated touches and strokes, with labels, for the command `simulate` and for calibration."""

import csv
from io import StringIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim_sensors.traces.simulated_stroke import StrokeTrace, simulate_stroke
from sim_sensors.traces.simulated_touch import ThermalTrace, check_range, known_material, simulate_thermal

LABELS = "labels.csv"


def write_thermal_csv(path: Path, trace: ThermalTrace) -> None:
    """Write one touch as `time_s,sensor_c,force_n,ambient_c`."""
    path.write_text(_thermal_csv(trace), "ascii")


def write_stroke_csv(path: Path, trace: StrokeTrace) -> None:
    """Write one stroke as `time_s,pressure_v,force_n,speed_mm_s`."""
    path.write_text(_stroke_csv(trace), "ascii")


def simulate_thermal_set(
    material: str,
    touches: int,
    *,
    seconds: float,
    seed: int,
    out: Path,
    force_n: float = 1.2,
    ambient_c: float = 23.0,
    preheat_k: float = 10.0,
    offset_c: tuple[float, float] = (-3.0, 3.0),
    block: bool = False,
) -> list[ThermalTrace]:
    """Write `touches` traces of a material (or `air`) and their labels `file,material,object_c` into `out`.

    Every touch meets a new piece of the material; with `block`, all touches meet its known block.

    Labels of other files in `out` are kept, so that sets of several materials can share the folder.

    Raises:
        ValueError: unknown material, a number out of range, a labels file of another kind in `out`, or a trace of
            another content that would be overwritten.
        OSError: `out` cannot be written.
    """
    name = known_material(material)
    traces = simulate_thermal(
        name,
        seed,
        touches=touches,
        seconds=seconds,
        force_n=force_n,
        ambient_c=ambient_c,
        preheat_k=preheat_k,
        offset_c=offset_c,
        block=block,
    )
    labels = _Labels(out, ("file", "material", "object_c"))
    files = {f"{name}_{seed}_{number:03d}.csv": trace for number, trace in enumerate(traces)}
    _write_new(out, {file: _thermal_csv(trace) for file, trace in files.items()})
    for file, trace in files.items():
        labels.add(file, name, "" if trace.object_c is None else f"{trace.object_c:.4f}")
    labels.write()
    return traces


def simulate_stroke_set(
    surface: str,
    strokes: int,
    *,
    speed_mm_s: float,
    force_n: float,
    seed: int,
    out: Path,
) -> list[StrokeTrace]:
    """Write `strokes` traces over a surface and their labels `file,surface` into `out`; other labels there are kept.

    Raises:
        ValueError: as `simulate_thermal_set`.
        OSError: `out` cannot be written.
    """
    check_range("strokes", strokes, 1, 1000)
    check_range("seed", seed, 0, 2**31)
    seeds = np.random.SeedSequence([seed, strokes]).generate_state(strokes)
    traces = [simulate_stroke(surface, int(one), speed_mm_s, force_n) for one in seeds]
    labels = _Labels(out, ("file", "surface"))
    files = {f"{surface}_{speed_mm_s:g}mm_s_{seed}_{number:03d}.csv": trace for number, trace in enumerate(traces)}
    _write_new(out, {file: _stroke_csv(trace) for file, trace in files.items()})
    for file in files:
        labels.add(file, surface)
    labels.write()
    return traces


def _thermal_csv(trace: ThermalTrace) -> str:
    columns = np.column_stack((trace.time_s, trace.sensor_c, trace.force_n, trace.ambient_c))
    return _csv(columns, ["%.3f", "%.4f", "%.4f", "%.4f"], "time_s,sensor_c,force_n,ambient_c")


def _stroke_csv(trace: StrokeTrace) -> str:
    columns = np.column_stack((trace.time_s, trace.pressure_v, trace.force_n, trace.speed_mm_s))
    return _csv(columns, ["%.4f", "%.5f", "%.4f", "%.3f"], "time_s,pressure_v,force_n,speed_mm_s")


def _csv(columns: NDArray[np.float64], formats: list[str], header: str) -> str:
    text = StringIO()
    np.savetxt(text, columns, formats, ",", header=header, comments="")
    return text.getvalue()


def _write_new(folder: Path, texts: dict[str, str]) -> None:
    """Write files; raise ValueError, and write none, if one exists with another content."""
    for name, text in texts.items():
        if (folder / name).exists() and (folder / name).read_bytes() != text.encode("ascii"):
            raise ValueError(f"{folder / name}: exists with another content; use another --seed or folder")
    for name, text in texts.items():
        (folder / name).write_text(text, "ascii")


class _Labels:
    """The labels file of a folder: read at the start, rewritten as a whole at the end."""

    def __init__(self, folder: Path, header: tuple[str, ...]) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._path = folder / LABELS
        self._header = header
        self._rows: dict[str, tuple[str, ...]] = {}
        if self._path.exists():
            try:
                with self._path.open(newline="", encoding="utf-8") as stream:
                    rows = list(csv.reader(stream))
            except (UnicodeDecodeError, csv.Error):
                raise ValueError(f"{self._path}: not a UTF-8 CSV file; write into another folder") from None
            if not rows or tuple(rows[0]) != header:
                raise ValueError(f"{self._path}: line 1 is not {','.join(header)!r}; write into another folder")
            self._rows = {row[0]: tuple(row) for row in rows[1:] if row}

    def add(self, *row: str) -> None:
        self._rows[row[0]] = row

    def write(self) -> None:
        with self._path.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(self._header)
            writer.writerows(self._rows[name] for name in sorted(self._rows))
