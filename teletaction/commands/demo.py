"""Command `demo`: runs a whole session on one machine."""

from pathlib import Path
from typing import Annotated

import typer

from teletaction.commands.failed import Failed
from teletaction.commands.out_file import out_folder

app = typer.Typer()


@app.command()
def demo(
    headless: Annotated[
        bool, typer.Option("--headless", help="No console: engage, run for --seconds, report.")
    ] = False,
    seconds: Annotated[
        float | None, typer.Option(help="Time that the simulated hand explores, s; 60 when headless.")
    ] = None,
    scene: Annotated[str, typer.Option(help="Scene of the simulated world.")] = "materials",
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random in the simulated world.")] = 0,
    fingers: Annotated[int, typer.Option(min=1, max=5, help="Number of fingers, 1 to 5.")] = 5,
    network: Annotated[
        str | None, typer.Option(help="Network between the sites: a name, a TOML file, or recorded round trips as CSV.")
    ] = None,
    rates: Annotated[
        str | None,
        typer.Option(help="Ticks a second, REMOTE,OPERATOR; by default the fastest that this machine can hold now."),
    ] = None,
    camera: Annotated[
        bool, typer.Option("--camera", help="Show a simulated camera at the console; needs the extra `camera`.")
    ] = False,
    voice: Annotated[
        bool, typer.Option("--voice", help="Let the console hear a tone from the remote site; needs the extra `voice`.")
    ] = False,
    consent: Annotated[
        str | None,
        typer.Option(
            metavar="KINDS",
            help="What the made-up patient agrees to have recorded: touch,pain,picture,voice. With picture, the "
            "console records the camera's pictures; with voice, the sound.",
        ),
    ] = None,
    patient_stop: Annotated[
        float | None,
        typer.Option(min=0.0, help="Time at which the patient presses the stop switch, s, from the first movement."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(callback=out_folder, help="Output folder; by default a new one in ~/.local/state/teletaction."),
    ] = None,
) -> None:
    """Run a whole telediagnosis session on this machine with simulated devices over the real transports."""
    from teletaction.session.demo import run_demo
    from teletaction.session.demo_files import DemoOptions
    from teletaction.session.session_rates import Rates, fitting_here

    options = DemoOptions(
        seconds=seconds if seconds is not None or not headless else 60.0,
        scene=scene,
        seed=seed,
        fingers=fingers,
        network=network,
        camera=camera,
        voice=voice,
        consent=None if consent is None else tuple(kind.strip() for kind in consent.split(",")),
        patient_stop_s=patient_stop,
        out=out,
        console=not headless,
        rates=fitting_here(console=not headless) if rates is None else Rates.read(rates),
    )
    failure = run_demo(options)
    if failure:
        raise Failed(failure)
