"""Command `identify`: identifies materials, surfaces and stiffness in recorded traces, as JSON lines."""

import json
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated

import typer

from common.runtime.parallel_map import processors
from teletaction.commands.progress import Processes, progress_line

app = typer.Typer(name="identify", help="Identification of recorded traces, as JSON lines.", no_args_is_help=True)


@app.command("thermal")
def identify_thermal_command(
    table: Annotated[Path, typer.Option(help="Calibrated table.")],
    traces: Annotated[list[Path] | None, typer.Argument(help="Trace files.")] = None,
    at: Annotated[str, typer.Option(help="Times after contact to answer at, s.")] = "0.5,1,2,3,5,7",
    touches: Annotated[
        Path | None, typer.Option(help="CSV `touch,trace`: traces of one touch are identified jointly.")
    ] = None,
    processes: Processes = 0,
) -> None:
    """Identify material and object temperature of recorded touches."""
    from remote_site.thermal.material_table import MaterialTable
    from remote_site.thermal.recorded.identify_thermal import identify_thermal

    if not traces and touches is None:
        raise ValueError("nothing to identify: name trace files, or --touches FILE")
    known, times = MaterialTable.load(table), _times(at)
    with progress_line("identify") as progress:
        _print_lines(identify_thermal(known, traces or [], times, touches, processes or processors(), progress))


@app.command("texture")
def identify_texture_command(
    strokes: Annotated[list[Path], typer.Argument(help="Stroke files.")],
    table: Annotated[Path | None, typer.Option(help="Calibrated table of surfaces.")] = None,
    signal: Annotated[str | None, typer.Option(help="Signal column, or `best` or `mean` of all.")] = None,
    speed: Annotated[float | None, typer.Option(help="Stroke speed for files without one, mm/s.")] = None,
    speed_sd: Annotated[float, typer.Option(help="Standard deviation of the speed's error, mm/s.")] = 0.0,
    processes: Processes = 0,
) -> None:
    """Identify mode, surface, grooves and rendering constants of recorded strokes."""
    from remote_site.texture.recorded.identify_texture import identify_texture, load_surfaces

    surfaces, workers = None if table is None else load_surfaces(table), processes or processors()
    with progress_line("identify") as progress:
        _print_lines(identify_texture(strokes, surfaces, signal, speed, workers, progress, speed_sd))


@app.command("stiffness")
def identify_stiffness_command(
    presses: Annotated[list[Path], typer.Argument(help="Files of presses; those of one file are of one object.")],
) -> None:
    """Identify stiffness, exponent and contact of recorded presses, with their uncertainties."""
    from remote_site.stiffness.recorded.identify_stiffness import identify_stiffness

    _print_lines(identify_stiffness(presses))


def _times(text: str) -> list[float]:
    try:
        times = [float(word) for word in text.split(",")]
    except ValueError:
        raise ValueError(f"--at {text!r}: expected times in seconds with commas between them") from None
    if not all(0.0 < t < 1e4 for t in times):
        raise ValueError(f"--at {text!r}: times must be above 0 and below 10000 s")
    return times


def _print_lines(records: Iterable[Mapping[str, object]]) -> None:
    for record in records:
        sys.stdout.write(json.dumps(record) + "\n")
