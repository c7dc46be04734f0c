"""`remote`, `operator`, `observe` and the simulations: one process of a session each, until it is told to stop."""

import typer

from teletaction.commands.config_file import ConfigFile

app = typer.Typer()


@app.command()
def remote(config: ConfigFile) -> None:
    """Run the remote site."""
    from common.config import RemoteConfig
    from common.process import run_process
    from remote_site.site import run_remote

    run_process("remote", config, RemoteConfig, run_remote)


@app.command()
def operator(config: ConfigFile) -> None:
    """Run the operator site."""
    from common.config import OperatorConfig
    from common.process import run_process
    from operator_site.site import run_operator

    run_process("operator", config, OperatorConfig, run_operator)


@app.command()
def observe(config: ConfigFile) -> None:
    """Look on at a session: what the remote site identifies, as JSON lines whenever it changes."""
    from common.config import ObserverConfig
    from common.process import run_process
    from operator_site.observer import run_observer

    run_process("observer", config, ObserverConfig, run_observer)


@app.command()
def sim_remote(config: ConfigFile) -> None:
    """Run the simulated devices of the remote site."""
    from common.config import SimRemoteConfig
    from common.process import run_process
    from sim_sensors.sim_remote import run_sim_remote

    run_process("sim-remote", config, SimRemoteConfig, run_sim_remote)


@app.command()
def sim_operator(config: ConfigFile) -> None:
    """Run the simulated devices and the scripted hand of the operator site."""
    from common.config import SimOperatorConfig
    from common.process import run_process
    from sim_sensors.sim_operator import run_sim_operator

    run_process("sim-operator", config, SimOperatorConfig, run_sim_operator)


@app.command()
@app.command("network", hidden=True)  # a demo names its processes by what they are
def sim_network(config: ConfigFile) -> None:
    """Run a simulated network between the two sites."""
    from common.config import SimNetworkConfig
    from common.process import run_process
    from sim_sensors.network_proxy import run_sim_network

    run_process("network", config, SimNetworkConfig, run_sim_network)
