"""`render`: what the operator's finger is made to feel, as CSV."""

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(name="render", help="What the operator's finger is made to feel, as CSV.", no_args_is_help=True)


@app.command("thermal")
def render_thermal_command(
    object_name: Annotated[str, typer.Option("--object", help="Material touched.")],
    object_c: Annotated[float, typer.Option(help="Object temperature, C.", min=-20.0, max=60.0)],
    air_c: Annotated[float, typer.Option(help="Air temperature, C.", min=-20.0, max=45.0)],
    seconds: Annotated[float, typer.Option(help="Length of the run, s; contact at 1.0 s.", min=0.01, max=3600.0)],
    model: Annotated[
        str | None,
        typer.Option(help="Cells: epidermis+dermis+subcutis+object. By default the fewest that are right enough."),
    ] = None,
    plate: Annotated[bool, typer.Option("--plate", help="Add the plate temperature that shows it.")] = False,
    parameters: Annotated[Path | None, typer.Option(help="Write every constant used, as JSON.")] = None,
) -> None:
    """What a fingertip feels in contact with an object, through the skin model."""
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
) -> None:
    """Motor speed that a recorded stroke makes the operator feel."""
    from operator_site.offline_rendering import VIBRATION_COLUMNS
    from remote_site.texture.surface_table import SurfaceTable
    from teletaction.replay.render_vibration import render_stroke
    from teletaction.session.demo_files import SURFACES

    _print_csv(VIBRATION_COLUMNS, render_stroke(stroke, SurfaceTable.load(table or SURFACES)))


def _print_csv(columns: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    sys.stdout.write(",".join(columns) + "\n")
    for row in rows:
        sys.stdout.write(",".join(f"{value:.7g}" for value in row) + "\n")
