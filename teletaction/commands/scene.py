"""Command `scene`: checks how well the operator site can display a scene."""

import csv
import sys
from typing import Annotated

import typer

app = typer.Typer(name="scene", help="Check how well the operator site can display a scene.", no_args_is_help=True)


@app.callback()
def scene() -> None:
    """Check how well the operator site can display a scene."""


@app.command("check")
def check_command(
    name: Annotated[str, typer.Argument(help="A scene's name, or a path that ends in .toml.")],
    dwell: Annotated[float, typer.Option(help="Contact time with each object, s.", min=0.1, max=10.0)] = 10.0,
) -> None:
    """Print the skin model chosen for each object, its predicted error and its cost, as CSV."""
    from common.scenes.scene import load_scene
    from teletaction.doctor.scene_check import COLUMNS, check_scene

    rows = csv.writer(sys.stdout, lineterminator="\n")
    checked = check_scene(load_scene(name), dwell)
    rows.writerow(COLUMNS)
    for one in checked:
        rows.writerow(
            f"{value:.3g}" if isinstance(value, float) else value
            for value in (getattr(one, field) for field in one.__slots__)
        )
