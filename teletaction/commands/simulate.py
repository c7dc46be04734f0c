"""Command `simulate`: writes traces and strokes of the simulated sensors, as CSV."""

from pathlib import Path
from typing import Annotated

import typer

from teletaction.commands.out_file import out_folder

app = typer.Typer(name="simulate", help="Traces from the simulated sensors, as CSV.", no_args_is_help=True)


@app.command("thermal")
def simulate_thermal_command(
    material: Annotated[str, typer.Option(help="Material touched, or `air` for free cooling.")],
    out: Annotated[Path, typer.Option(callback=out_folder, help="Folder for the traces and labels.csv.")],
    touches: Annotated[int, typer.Option(help="Number of touches.", min=1)] = 1,
    seconds: Annotated[float, typer.Option(help="Time in contact, s.", min=0.5, max=120.0)] = 8.1,
    seed: Annotated[int, typer.Option(help="Seed of all random values.", min=0)] = 0,
    ambient_c: Annotated[float, typer.Option(help="Air temperature, C.", min=5.0, max=35.0)] = 23.0,
    preheat_k: Annotated[float, typer.Option(help="Sensor above ambient before contact, K.", min=0.0, max=19.0)] = 10.0,
    object_c: Annotated[
        float | None, typer.Option(help="Object temperature, C; by default within 3 K of ambient.", min=-10.0, max=60.0)
    ] = None,
    block: Annotated[bool, typer.Option(help="Touch one block each time, not a new piece of the material.")] = False,
) -> None:
    """Simulate touches of the thermal sensor."""
    from common.scenes.materials import material as look_up
    from sim_sensors.traces.simulate import simulate_thermal_set

    if material != "air":
        look_up(material)
    offset_c = (-3.0, 3.0) if object_c is None else (object_c - ambient_c,) * 2
    simulate_thermal_set(
        material,
        touches,
        seconds=seconds,
        seed=seed,
        out=out,
        ambient_c=ambient_c,
        preheat_k=preheat_k,
        offset_c=offset_c,
        block=block,
    )
    typer.echo(f"wrote {touches} {'touch' if touches == 1 else 'touches'} of {material} to {out}", err=True)


@app.command("stroke")
def simulate_stroke_command(
    surface: Annotated[str, typer.Option(help="Surface stroked.")],
    out: Annotated[Path, typer.Option(callback=out_folder, help="Folder for the strokes and labels.csv.")],
    strokes: Annotated[int, typer.Option(help="Number of strokes.", min=1)] = 1,
    speed: Annotated[float, typer.Option(help="Stroke speed, mm/s.", min=5.0, max=200.0)] = 50.0,
    force: Annotated[float, typer.Option(help="Contact force, N.", min=0.5, max=5.0)] = 1.2,
    seed: Annotated[int, typer.Option(help="Seed of all random values.", min=0)] = 0,
) -> None:
    """Simulate strokes of the texture sensor."""
    from sim_sensors.traces.simulate import simulate_stroke_set

    simulate_stroke_set(surface, strokes, speed_mm_s=speed, force_n=force, seed=seed, out=out)
    typer.echo(f"wrote {strokes} {'stroke' if strokes == 1 else 'strokes'} of {surface} to {out}", err=True)
