"""Commands that run one process of a session each until it is stopped: sites, console, observer, simulations."""

from pathlib import Path
from typing import Annotated

import typer

from teletaction.commands.config_file import ConfigFile, OwnConfigFile, own_config
from teletaction.commands.key_option import Key

app = typer.Typer()


@app.command()
def remote(config: OwnConfigFile = None) -> None:
    """Run the remote site."""
    from common.config.site_models import RemoteConfig
    from common.process import run_process
    from remote_site.site import run_remote

    run_process("remote", own_config(config, "remote"), RemoteConfig, run_remote)


@app.command()
def camera(config: OwnConfigFile = None) -> None:
    """Run the remote site's camera."""
    _require("av", "the camera", "camera")
    from common.config.stream_models import CameraConfig
    from common.process import run_process
    from remote_site.camera.camera import run_camera

    run_process("camera", own_config(config, "camera"), CameraConfig, run_camera)


@app.command()
def patient_page(config: OwnConfigFile = None) -> None:
    """Serve the patient's stop switch and pain slider as a page for a tablet."""
    _require("starlette", "the patient's page", "console")
    from common.config.page_models import PatientPageConfig
    from common.process import run_process
    from remote_site.patient_page.run import run_patient_page

    run_process("patient-page", own_config(config, "patient-page"), PatientPageConfig, run_patient_page)


@app.command()
def voice(config: OwnConfigFile = None) -> None:
    """Run the remote site's voice."""
    _require("av", "the voice", "voice")
    from common.config.stream_models import VoiceConfig
    from common.process import run_process
    from remote_site.voice.voice import run_voice

    run_process("voice", own_config(config, "voice"), VoiceConfig, run_voice)


@app.command()
def operator(config: OwnConfigFile = None) -> None:
    """Run the operator site."""
    from common.config.site_models import OperatorConfig
    from common.process import run_process
    from operator_site.site import run_operator

    run_process("operator", own_config(config, "operator"), OperatorConfig, run_operator)


@app.command()
def virtual(
    scene: Annotated[str, typer.Option(help="Scene to touch: its name, or a path that ends in .toml.")],
    config: OwnConfigFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random values: temperatures, arbitrary grooves.")] = 0,
) -> None:
    """Run the operator site on a virtual environment, without any remote site."""
    from functools import partial

    from common.config.site_models import OperatorConfig
    from common.process import run_process
    from common.scenes.scene import load_scene
    from operator_site.virtual.virtual_site import run_virtual

    run = partial(run_virtual, scene=load_scene(scene), seed=seed)
    run_process("virtual", own_config(config, "operator"), OperatorConfig, run)


@app.command()
def console(
    config: OwnConfigFile = None,
    play: Annotated[Path | None, typer.Option(help="Merged recording of a session to play back instead.")] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port of the page with --play; 0 takes a free one.")
    ] = 8090,
    key: Key = None,
) -> None:
    """Serve the console, a web page, for a running operator site or for a recording."""
    _require("starlette", "the console", "console")
    if config is not None and play is not None:
        raise ValueError("console: give either --config FILE or --play SESSION.mcap")
    from common.config.page_models import ConsoleConfig
    from common.logs import log_to_stderr
    from common.process import StopSignal, run_process
    from operator_site.console.run import run_console, run_playback

    if play is None:
        run_process("console", own_config(config, "console"), ConsoleConfig, run_console)
    else:
        log_to_stderr("console")
        run_playback(play, port, StopSignal())


@app.command()
def observe(config: OwnConfigFile = None) -> None:
    """Watch a session read-only: print what the remote site identifies as JSON lines whenever it changes."""
    from common.config.link_models import ObserverConfig
    from common.process import run_process
    from operator_site.session.read_only_client import run_observer

    run_process("observer", own_config(config, "observer"), ObserverConfig, run_observer)


@app.command()
def rendezvous(config: OwnConfigFile = None) -> None:
    """Run a rendezvous, at which two sites meet that cannot connect to each other."""
    from common.config.link_models import RendezvousConfig
    from common.process import run_process
    from teletaction.tunnel.rendezvous import run_rendezvous

    run_process("rendezvous", own_config(config, "rendezvous"), RendezvousConfig, run_rendezvous)


@app.command()
def tunnel(config: OwnConfigFile = None) -> None:
    """Run one site's end of a tunnel over a rendezvous."""
    from common.config.link_models import TunnelConfig
    from common.process import run_process
    from teletaction.tunnel.tunnel_end import run_tunnel

    run_process("tunnel", own_config(config, "tunnel"), TunnelConfig, run_tunnel)


@app.command()
def sim_remote(config: ConfigFile) -> None:
    """Run the simulated devices of the remote site."""
    from common.config.simulation_models import SimRemoteConfig
    from common.process import run_process
    from sim_sensors.remote_devices import run_sim_remote

    run_process("sim-remote", config, SimRemoteConfig, run_sim_remote)


@app.command()
def sim_operator(config: ConfigFile) -> None:
    """Run the simulated devices and the scripted hand of the operator site."""
    from common.config.simulation_models import SimOperatorConfig
    from common.process import run_process
    from sim_sensors.operator_devices import run_sim_operator

    run_process("sim-operator", config, SimOperatorConfig, run_sim_operator)


@app.command()
@app.command("network", hidden=True)  # The demo starts this process under the name network.
def sim_network(config: ConfigFile) -> None:
    """Run a simulated network between the two sites."""
    from common.config.simulation_models import SimNetworkConfig
    from common.process import run_process
    from sim_sensors.network.proxy import run_sim_network

    run_process("network", config, SimNetworkConfig, run_sim_network)


def _require(package: str, what: str, extra: str) -> None:
    """Raise ValueError if a process lacks a package of an extra."""
    from importlib.util import find_spec

    if find_spec(package) is None:
        raise ValueError(f"{what} needs `pip install teletaction[{extra}]`")
