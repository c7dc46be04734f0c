"""Command `map`: makes the tactile map of recorded presses, strokes and rests."""

import os
from pathlib import Path
from typing import Annotated

import typer

from teletaction.commands.out_file import out_folder

app = typer.Typer()


@app.command("map")
def map_command(
    recorded: Annotated[
        list[Path],
        typer.Argument(metavar="PRESSES", help="Files of presses, or of lines with roughness_v or object_c."),
    ],
    out: Annotated[Path, typer.Option(callback=out_folder, help="Folder for map.csv, map.png and map.json.")],
    probe_radius_mm: Annotated[
        float,
        typer.Option(min=0.5, max=20.0, help="Radius of the probe or fingertip, mm, for depth and size of a lump."),
    ] = 4.0,
) -> None:
    """Make the tactile map of recorded presses, with the probability that each place belongs to a lump."""
    from teletaction.mapping.map_recorded import map_recorded
    from teletaction.mapping.write_map import FILES, write_map

    written = [os.path.realpath(out / name) for name in FILES]
    for path in recorded:
        if os.path.realpath(path) in written:
            raise ValueError(f"{path}: the map would overwrite it; name another folder with --out")
    summary = write_map(map_recorded(recorded), out, 1e-3 * probe_radius_mm)
    used, presses, lumps = summary["used"], summary["presses"], len(summary["lumps"])
    typer.echo(f"used {used} of {presses} presses, found {lumps} {'lump' if lumps == 1 else 'lumps'}", err=True)
    typer.echo(f"wrote {out}", err=True)
