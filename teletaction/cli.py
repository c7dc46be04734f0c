"""The command line. Human text to stderr, data to stdout; exit 0, 1 (failed) or 2 (bad input, one clear line).

Commands import what they need when they run: a site's process must not carry the weight of the others.
"""

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from common.config import (
    ObserverConfig,
    OperatorConfig,
    RemoteConfig,
    SimNetworkConfig,
    SimOperatorConfig,
    SimRemoteConfig,
)
from common.process import run_process

if TYPE_CHECKING:
    from common.keys import KeyPair

app = typer.Typer(
    name="teletaction",
    help="Feel a remote place with five fingers: texture, temperature and stiffness over an ordinary network.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
keys_app = typer.Typer(help="CurveZMQ keys of a site and the list of those it trusts.", no_args_is_help=True)
calibrate_app = typer.Typer(help="Look-up tables from labelled recordings.", no_args_is_help=True)
identify_app = typer.Typer(help="Identification of recorded traces, as JSON lines.", no_args_is_help=True)
simulate_app = typer.Typer(help="Traces from the simulated sensors, as CSV.", no_args_is_help=True)
render_app = typer.Typer(help="What the operator's finger is made to feel, as CSV.", no_args_is_help=True)
session_app = typer.Typer(help="What a person at a running site asks of it.", no_args_is_help=True)
for name, group in (
    ("keys", keys_app),
    ("session", session_app),
    ("calibrate", calibrate_app),
    ("identify", identify_app),
    ("simulate", simulate_app),
    ("render", render_app),
):
    app.add_typer(group, name=name)

ConfigFile = Annotated[Path, typer.Option("--config", help="TOML file of this process.")]
KeyFolder = Annotated[Path, typer.Option("--keys", help="Key folder of the site.")]


class Failed(Exception):
    """Work that was asked for rightly and did not succeed: exit 1."""


@app.command()
def demo(
    headless: Annotated[bool, typer.Option("--headless", help="Run for --seconds, report, and end.")] = False,
    seconds: Annotated[float | None, typer.Option(help="How long the hand works; 60 when headless.")] = None,
    scene: Annotated[str, typer.Option(help="Scene of the simulated world.")] = "materials",
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random in the simulated world.")] = 0,
    fingers: Annotated[int, typer.Option(min=1, max=5, help="How many fingers, 1 to 5.")] = 5,
    network: Annotated[
        str | None, typer.Option(help="Network between the sites: a name, a TOML file, or recorded round trips as CSV.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Output folder; by default a new one.")] = None,
) -> None:
    """A whole telediagnosis session on this machine with simulated devices over the real transports."""
    from teletaction.demo import run_demo
    from teletaction.demo_files import DemoOptions

    options = DemoOptions(
        seconds=seconds if seconds is not None or not headless else 60.0,
        scene=scene,
        seed=seed,
        fingers=fingers,
        network=network,
        out=out,
    )
    failure = run_demo(options)
    if failure:
        raise Failed(failure)


@app.command()
def remote(config: ConfigFile) -> None:
    """Run the remote site."""
    from remote_site.site import run_remote

    run_process("remote", config, RemoteConfig, run_remote)


@app.command()
def operator(config: ConfigFile) -> None:
    """Run the operator site."""
    from operator_site.site import run_operator

    run_process("operator", config, OperatorConfig, run_operator)


@app.command()
def observe(config: ConfigFile) -> None:
    """Look on at a session: what the remote site identifies, as JSON lines whenever it changes."""
    from operator_site.observer import run_observer

    run_process("observer", config, ObserverConfig, run_observer)


@app.command()
def sim_remote(config: ConfigFile) -> None:
    """Run the simulated devices of the remote site."""
    from sim_sensors.sim_remote import run_sim_remote

    run_process("sim-remote", config, SimRemoteConfig, run_sim_remote)


@app.command()
def sim_operator(config: ConfigFile) -> None:
    """Run the simulated devices and the scripted hand of the operator site."""
    from sim_sensors.sim_operator import run_sim_operator

    run_process("sim-operator", config, SimOperatorConfig, run_sim_operator)


@app.command()
@app.command("network", hidden=True)  # a demo names its processes by what they are
def sim_network(config: ConfigFile) -> None:
    """Run a simulated network between the two sites."""
    from sim_sensors.network_proxy import run_sim_network

    run_process("network", config, SimNetworkConfig, run_sim_network)


@app.command("summarise")
def summarise_command(
    recordings: Annotated[Path, typer.Option(help="Folder with the recordings and status files of all processes.")],
    out: Annotated[Path, typer.Option(help="Folder for session.mcap, summary.json and report.html.")],
    scene: Annotated[str, typer.Option(help="Scene that was explored.")] = "materials",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulated world.")] = 0,
    fingers: Annotated[int, typer.Option(min=1, max=5, help="How many fingers, 1 to 5.")] = 5,
) -> None:
    """Recording, summary and report of a session whose processes were started one by one."""
    from teletaction.conclude import conclude
    from teletaction.demo_files import DemoOptions

    conclude(recordings, out, DemoOptions(scene=scene, seed=seed, fingers=fingers))
    typer.echo(f"summary {out / 'summary.json'}, report {out / 'report.html'}", err=True)


@app.command("recover")
def recover_command(
    recording: Annotated[Path, typer.Argument(help="Recording of a process that did not end by itself.")],
    out: Annotated[Path | None, typer.Option(help="File to write; by default NAME-recovered.mcap beside it.")] = None,
) -> None:
    """Make a whole recording out of a cut one; the original stays as it is."""
    from teletaction.recover import recover

    recovered = recover(recording, out)
    if recovered is None:
        typer.echo(f"{recording} is whole: nothing needs repair", err=True)
        return
    for stream, count in sorted(recovered.messages.items()):
        typer.echo(f"{count:9d} {stream}", err=True)
    typer.echo(
        f"wrote {recovered.out}: {recovered.messages.total()} messages over {recovered.seconds:.3f} s; "
        f"{recovered.unreadable_bytes} bytes at the end and {recovered.damaged_chunks} damaged chunks before it "
        "could not be read",
        err=True,
    )


@app.command("replay")
def replay_command(
    recording: Annotated[Path, typer.Argument(help="Recording of a session, or of one site.")],
    out: Annotated[Path, typer.Option(help="Folder for identification.jsonl, rendering.csv and replay.json.")],
) -> None:
    """Run identification and rendering again on a recording, and compare with what was computed then."""
    from teletaction.replay import replay

    with _progress("replaying") as progress:
        result = replay(recording, out, progress)
    for site, what in (("remote", "touch_packets"), ("operator", "rendered_rows")):
        for name, part in result[site].items():
            same = "all" if part["identical"] == part[what] else f"only {part['identical']}"
            typer.echo(
                f"{name}: {part['ticks']} ticks; {same} of {part[what]} {what.replace('_', ' ')} are identical",
                err=True,
            )


@app.command()
def doctor(config: ConfigFile) -> None:
    """Find and name each device of a site's configuration; check keys and clocks; say what to do."""
    from teletaction.doctor import examine

    findings = examine(config)
    for finding in findings:
        typer.echo(f"{'ok  ' if finding.good else 'FAIL'} {finding.what}: {finding.result}")
    bad = [finding for finding in findings if not finding.good]
    if bad:
        raise Failed(f"{len(bad)} of {len(findings)} checks failed; first: {bad[0].what}: {bad[0].result}")


@app.command("metrics")
def metrics_command(
    status: Annotated[list[Path], typer.Option("--status", help="Status file of a process; once for each.")],
    listen: Annotated[str, typer.Option(help="HOST:PORT to serve.")] = "127.0.0.1:9634",
    token_file: Annotated[
        Path | None, typer.Option(help="File (mode 0600) with the token that a request must carry.")
    ] = None,
) -> None:
    """Serve the figures of running processes to Prometheus, from their status files alone."""
    from common.logs import log_to_stderr
    from common.process import StopSignal

    try:
        from teletaction.metrics import StatusCollector
        from teletaction.metrics_server import MetricsServer, read_token
    except ModuleNotFoundError as missing:
        raise ValueError(f"metrics need {missing.name}: install `teletaction[metrics]`") from None

    token = None if token_file is None else read_token(token_file)
    with MetricsServer(listen, StatusCollector(status), token) as server:
        log_to_stderr("metrics")
        server.serve(StopSignal())


@keys_app.command("init")
def keys_init(keys: KeyFolder) -> None:
    """Make a key pair; prints the public key."""
    from common.keys import create_keys

    typer.echo(create_keys(keys))


@keys_app.command("show")
def keys_show(keys: KeyFolder) -> None:
    """Print the site's public key, its fingerprint, and whom it trusts."""
    from common.keys import TrustedKeys, fingerprint, load_keys

    own = load_keys(keys)
    typer.echo(f"own {fingerprint(own.public)} {own.public}")
    for key, owner in TrustedKeys(keys).owners().items():
        typer.echo(f"trusted {owner.name} ({owner.role.value}) {fingerprint(key)} {key}")


@keys_app.command("trust")
def keys_trust(
    name: str,
    public_key: str,
    keys: KeyFolder,
    observer: Annotated[bool, typer.Option("--observer", help="The owner may look on, and change nothing.")] = False,
) -> None:
    """Allow a public key under a name."""
    from common.keys import Role, TrustedKeys

    TrustedKeys(keys).trust(name, public_key, Role.OBSERVER if observer else Role.PARTNER)


@keys_app.command("revoke")
def keys_revoke(name: str, keys: KeyFolder) -> None:
    """Allow the keys of a name no longer; a running site cuts their connections within about a second."""
    from common.keys import TrustedKeys

    count = TrustedKeys(keys).revoke(name)
    typer.echo(f"revoked {count} key{'s' if count != 1 else ''} of {name}", err=True)


@session_app.command("status")
def session_status(config: ConfigFile) -> None:
    """Print what a running site says of its session, as JSON."""
    typer.echo(json.dumps(_ask_desk(config, "status")))


@session_app.command("engage")
def session_engage(config: ConfigFile) -> None:
    """Ask for outputs to act, at the operator's site; both sites must agree."""
    _ask_desk(config, "engage")


@session_app.command("disengage")
def session_disengage(config: ConfigFile) -> None:
    """Bring all outputs to neutral."""
    _ask_desk(config, "disengage")


@session_app.command("estop")
def session_estop(config: ConfigFile) -> None:
    """Emergency stop; waits for the devices to confirm and prints what they said."""
    from common.desk import stop_from_desk

    outcome = stop_from_desk(*_desk(config))
    typer.echo(outcome)
    if "not confirmed" in outcome:
        raise Failed(outcome)


@session_app.command("clear")
def session_clear(config: ConfigFile) -> None:
    """Clear a latched fault, at both sites where that may be done from here; nothing moves until engaged again."""
    from common.desk import clear_from_desk
    from common.session import Refused

    try:
        clear_from_desk(*_desk(config))
    except Refused as refusal:
        raise Failed(f"clear: {refusal}") from None


@session_app.command("note")
def session_note(text: str, config: ConfigFile) -> None:
    """Write a note into the session's recording, at the operator's site."""
    _ask_desk(config, "annotate", {"text": text})


def _desk(config: Path) -> "tuple[int, KeyPair]":
    from common.config import load_site
    from common.keys import load_keys

    site = load_site(config)
    return site.desk_port, load_keys(site.link.keys)


def _ask_desk(config: Path, verb: str, details: dict[str, object] | None = None) -> dict[str, object]:
    from common.desk import ask_desk
    from common.session import Refused

    try:
        return ask_desk(*_desk(config), verb, details)
    except Refused as refusal:
        raise Failed(f"{verb}: {refusal}") from None


@calibrate_app.command("thermal")
def calibrate_thermal_command(
    traces: Annotated[Path, typer.Option(help="Folder with traces and labels.csv (file,material[,object_c]).")],
    out: Annotated[Path, typer.Option(help="Table to write.")],
    serial: Annotated[str, typer.Option(help="Serial number of the calibrated sensor.")] = "unknown",
) -> None:
    """Material look-up table from labelled touches."""
    from remote_site.thermal_calibration import calibrate_thermal

    calibrate_thermal(traces, out, sensor_serial=serial, made_on=f"{date.today()}")
    typer.echo(f"wrote {out}", err=True)


@calibrate_app.command("texture")
def calibrate_texture_command(
    strokes: Annotated[Path, typer.Option(help="Folder with strokes and labels.csv (file,surface).")],
    out: Annotated[Path, typer.Option(help="Table to write.")],
    serial: Annotated[str, typer.Option(help="Serial number of the calibrated sensor.")] = "unknown",
) -> None:
    """Surface look-up table from labelled strokes."""
    from remote_site.texture_calibration import calibrate_texture

    calibrate_texture(strokes, out, sensor_serial=serial, made_on=f"{date.today()}")
    typer.echo(f"wrote {out}", err=True)


@identify_app.command("thermal")
def identify_thermal_command(
    table: Annotated[Path, typer.Option(help="Calibrated table.")],
    traces: Annotated[list[Path] | None, typer.Argument(help="Trace files.")] = None,
    at: Annotated[str, typer.Option(help="Times after contact to answer at, s.")] = "0.5,1,2,3,5,7",
    touches: Annotated[Path | None, typer.Option(help="CSV `touch,trace`: traces judged jointly.")] = None,
) -> None:
    """Material and object temperature of recorded touches."""
    from remote_site.identify_thermal import identify_thermal
    from remote_site.material_table import MaterialTable

    if not traces and touches is None:
        raise ValueError("nothing to identify: name trace files, or --touches FILE")
    _print_lines(identify_thermal(MaterialTable.load(table), traces or [], _times(at), touches))


@identify_app.command("texture")
def identify_texture_command(
    strokes: Annotated[list[Path], typer.Argument(help="Stroke files.")],
    table: Annotated[Path | None, typer.Option(help="Calibrated table of surfaces.")] = None,
    signal: Annotated[str | None, typer.Option(help="Signal column, or `best` or `mean` of all.")] = None,
    speed: Annotated[float | None, typer.Option(help="Stroke speed in mm/s where the file has none.")] = None,
) -> None:
    """Mode, surface, grooves and rendering constants of recorded strokes."""
    from remote_site.identify_texture import identify_texture
    from remote_site.surface_class import SurfaceTable

    surfaces = None if table is None else SurfaceTable.load(table)
    _print_lines(identify_texture(strokes, surfaces, signal, speed))


@simulate_app.command("thermal")
def simulate_thermal_command(
    material: Annotated[str, typer.Option(help="Material touched, or `air` for free cooling.")],
    out: Annotated[Path, typer.Option(help="Folder for the traces and labels.csv.")],
    touches: Annotated[int, typer.Option(min=1)] = 1,
    seconds: Annotated[float, typer.Option(help="Time in contact, s.", min=0.5, max=120.0)] = 8.1,
    seed: Annotated[int, typer.Option(min=0)] = 0,
    ambient_c: Annotated[float, typer.Option(min=5.0, max=35.0)] = 23.0,
    preheat_k: Annotated[float, typer.Option(min=0.0, max=19.0)] = 10.0,
    object_c: Annotated[
        float | None, typer.Option(help="Object temperature; by default within 3 K of ambient.", min=-10.0, max=60.0)
    ] = None,
) -> None:
    """Touches of the simulated thermal sensor."""
    from common.materials import material as look_up
    from sim_sensors.simulate import simulate_thermal_set

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
    )
    typer.echo(f"wrote {touches} touches of {material} to {out}", err=True)


@simulate_app.command("stroke")
def simulate_stroke_command(
    surface: Annotated[str, typer.Option(help="Surface stroked.")],
    out: Annotated[Path, typer.Option(help="Folder for the strokes and labels.csv.")],
    strokes: Annotated[int, typer.Option(min=1)] = 1,
    speed: Annotated[float, typer.Option(help="mm/s", min=5.0, max=200.0)] = 50.0,
    force: Annotated[float, typer.Option(help="N", min=0.3, max=5.0)] = 1.2,
    seed: Annotated[int, typer.Option(min=0)] = 0,
) -> None:
    """Strokes of the simulated texture sensor."""
    from sim_sensors.simulate import simulate_stroke_set

    simulate_stroke_set(surface, strokes, speed_mm_s=speed, force_n=force, seed=seed, out=out)
    typer.echo(f"wrote {strokes} strokes of {surface} to {out}", err=True)


@render_app.command("thermal")
def render_thermal_command(
    object_name: Annotated[str, typer.Option("--object", help="Material touched.")],
    object_c: Annotated[float, typer.Option(help="Object temperature, C.", min=-20.0, max=60.0)],
    air_c: Annotated[float, typer.Option(help="Air temperature, C.", min=-20.0, max=45.0)],
    seconds: Annotated[float, typer.Option(help="Length of the run, s; contact at 1.0 s.", min=0.01, max=3600.0)],
    model: Annotated[str, typer.Option(help="Cells: epidermis+dermis+subcutis+object.")] = "4+1+1+6",
    plate: Annotated[bool, typer.Option("--plate", help="Add the plate temperature that shows it.")] = False,
    parameters: Annotated[Path | None, typer.Option(help="Write every constant used, as JSON.")] = None,
) -> None:
    """What a fingertip feels in contact with an object, through the skin model."""
    from operator_site.render import PLATE_COLUMN, THERMAL_COLUMNS, render_thermal, write_parameters

    rows = render_thermal(object_name, object_c, air_c, seconds, model=model, plate=plate)
    if parameters is not None:
        write_parameters(parameters, object_name, object_c, air_c, model=model)
    _print_csv((*THERMAL_COLUMNS, PLATE_COLUMN) if plate else THERMAL_COLUMNS, rows)


@render_app.command("vibration")
def render_vibration_command(
    stroke: Annotated[Path, typer.Argument(help="Stroke file.")],
    table: Annotated[
        Path | None, typer.Option(help="Calibrated table of surfaces; by default the shipped one.")
    ] = None,
) -> None:
    """Motor speed that a recorded stroke makes the operator feel."""
    from operator_site.render import VIBRATION_COLUMNS
    from remote_site.surface_class import SurfaceTable
    from teletaction.demo_files import SURFACES
    from teletaction.render_vibration import render_stroke

    _print_csv(VIBRATION_COLUMNS, render_stroke(stroke, SurfaceTable.load(table or SURFACES)))


@app.command("study")
def study_command(
    name: Annotated[str | None, typer.Argument(help="Which study; --list tells what there are.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for NAME.json, NAME-TABLE.csv and NAME.png.")] = None,
    list_studies: Annotated[bool, typer.Option("--list", help="Print each study's name and what it shows.")] = False,
    all_studies: Annotated[bool, typer.Option("--all", help="Run all studies, one after the other.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Measure less, and sooner.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random in a study.")] = 0,
) -> None:
    """Measure the system under conditions set on purpose: data as JSON and CSV, and a figure."""
    from importlib import import_module

    # By name: nothing but this command may depend on the studies, and they may depend on everything.
    registry = import_module("studies.registry")
    if list_studies:
        for study_name, line in registry.described().items():
            typer.echo(f"{study_name}: {line}")
        return
    if all_studies == (name is not None):
        raise ValueError(f"name one study, or --all; there are {', '.join(registry.STUDIES)}")
    names: list[str] = list(registry.STUDIES) if name is None else [name]
    for study_name in names:
        registry.study(study_name)
    if out is None:
        raise ValueError("a study needs --out DIR")
    for study_name in names:
        with _progress_line(study_name) as tell:
            written = registry.run_study(study_name, out, quick=quick, seed=seed, tell=tell)
        typer.echo(f"{study_name}: wrote {', '.join(str(path) for path in written)}", err=True)


@contextmanager
def _progress_line(label: str) -> Iterator[Callable[[float | str], None]]:
    """A line on a terminal that says how far something is, the share done (0..1) or in words; nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    clear = "\r\x1b[K"
    try:
        yield lambda far: typer.echo(
            f"{clear}{label}: {far if isinstance(far, str) else f'{far:.0%}'}", err=True, nl=False
        )
    finally:
        typer.echo(clear, err=True, nl=False)


@contextmanager
def _progress(label: str) -> Iterator[Callable[[float], None] | None]:
    """A progress bar on a terminal that takes the share done, 0..1; nothing elsewhere."""
    if not sys.stderr.isatty():
        yield None
        return
    with typer.progressbar(length=1000, label=label, file=sys.stderr) as bar:
        yield lambda share: bar.update(round(share * 1000) - bar.pos)


def _times(text: str) -> list[float]:
    try:
        times = [float(word) for word in text.split(",")]
    except ValueError:
        raise ValueError(f"--at {text!r}: expected times in seconds with commas between them") from None
    if not times or not all(0.0 < t < 1e4 for t in times):
        raise ValueError(f"--at {text!r}: times must be above 0 s")
    return times


def _print_lines(records: Iterable[Mapping[str, object]]) -> None:
    for record in records:
        sys.stdout.write(json.dumps(record) + "\n")


def _print_csv(columns: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    sys.stdout.write(",".join(columns) + "\n")
    for row in rows:
        sys.stdout.write(",".join(f"{value:.7g}" for value in row) + "\n")


def main(arguments: list[str] | None = None) -> int:
    """Run one command; returns its exit code."""
    try:
        # Only a command that was interrupted, or that ends early, has a code of its own.
        return app(args=arguments, standalone_mode=False) or 0
    except typer.TyperException as error:
        message = error.format_message()
        if "\n" in message:  # a command without arguments: the message is its help
            typer.echo(message, err=True)
            return 2
        return _complain(message, 2)
    except (ValueError, KeyError, OSError) as error:
        if isinstance(error, BrokenPipeError):
            return 0  # whoever read our output has enough
        return _complain(str(error.args[0]) if isinstance(error, KeyError) else str(error), 2)
    except Failed as failure:
        return _complain(str(failure), 1)
    except (KeyboardInterrupt, typer.Abort):
        return 130


def _complain(message: str, code: int) -> int:
    typer.echo("teletaction: " + " ".join(message.split()), err=True)
    return code
