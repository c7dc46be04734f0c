"""Command `render`: computes the display at the operator's finger off line, as CSV."""

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    name="render", help="Thermal and vibration display at the operator's finger, as CSV.", no_args_is_help=True
)


@app.command("thermal")
def render_thermal_command(
    object_name: Annotated[str, typer.Option("--object", help="Material touched.")],
    object_c: Annotated[float, typer.Option(help="Object temperature, C.", min=-20.0, max=60.0)],
    air_c: Annotated[float, typer.Option(help="Air temperature, C.", min=-20.0, max=45.0)],
    seconds: Annotated[float, typer.Option(help="Length of the run, s; contact at 1.0 s.", min=0.01, max=3600.0)],
    model: Annotated[
        str | None,
        typer.Option(
            help="Cells: epidermis+dermis+subcutis+object. By default the smallest model within the tolerance."
        ),
    ] = None,
    plate: Annotated[bool, typer.Option("--plate", help="Add the plate temperature that displays it.")] = False,
    parameters: Annotated[Path | None, typer.Option(help="Write every constant used, as JSON.")] = None,
) -> None:
    """Compute skin temperatures of a fingertip in contact with an object, by the skin model."""
    from operator_site.offline_rendering import PLATE_COLUMN, THERMAL_COLUMNS, render_thermal, write_parameters

    rows = render_thermal(object_name, object_c, air_c, seconds, model=model, plate=plate)
    if parameters is not None:
        write_parameters(parameters, object_name, object_c, air_c, model=model)
    _print_csv((*THERMAL_COLUMNS, PLATE_COLUMN) if plate else THERMAL_COLUMNS, rows)


@app.command("vibration")
def render_vibration_command(
    stroke: Annotated[Path, typer.Argument(help="Stroke file.")],
    table: Annotated[
        Path | None, typer.Option(help="Calibrated table of surfaces; by default the shipped one.")
    ] = None,
    signal: Annotated[str | None, typer.Option(help="Signal column, or `best` or `mean` of all.")] = None,
) -> None:
    """Compute the motor speed that displays a recorded stroke."""
    from operator_site.offline_rendering import VIBRATION_COLUMNS
    from remote_site.texture.surface_table import SurfaceTable
    from remote_site.traces.trace_files import read_stroke
    from teletaction.replay.render_vibration import render_stroke
    from teletaction.session.demo_files import SURFACES

    _print_csv(VIBRATION_COLUMNS, render_stroke(read_stroke(stroke, signal), SurfaceTable.load(table or SURFACES)))


def _print_csv(columns: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    sys.stdout.write(",".join(columns) + "\n")
    for row in rows:
        sys.stdout.write(",".join(f"{value:.7g}" for value in row) + "\n")
