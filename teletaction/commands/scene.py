"""Command `scene`: checks how well the operator site can display a scene."""

import csv
import sys
from typing import Annotated

import typer

from teletaction.commands.as_json import Json, print_json

app = typer.Typer(name="scene", help="Check how well the operator site can display a scene.", no_args_is_help=True)


@app.callback()
def scene() -> None:
    """Check how well the operator site can display a scene."""


@app.command("check")
def check_command(
    name: Annotated[str, typer.Argument(help="A scene's name, or a path that ends in .toml.")],
    dwell: Annotated[float, typer.Option(help="Contact time with each object, s.", min=0.1, max=10.0)] = 10.0,
    as_json: Json = False,
) -> None:
    """Print the skin model chosen for each object, its predicted error and its cost, as CSV."""
    from common.scenes.scene import load_scene
    from teletaction.doctor.scene_check import COLUMNS, check_scene

    checked = [[getattr(one, field) for field in one.__slots__] for one in check_scene(load_scene(name), dwell)]
    checked = [[value if isinstance(value, int | float) else str(value) for value in values] for values in checked]
    if as_json:
        print_json({"objects": [dict(zip(COLUMNS, values, strict=True)) for values in checked]})
        return
    rows = csv.writer(sys.stdout, lineterminator="\n")
    rows.writerow(COLUMNS)
    for values in checked:
        rows.writerow(f"{value:.3g}" if isinstance(value, float) else value for value in values)
