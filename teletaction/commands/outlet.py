"""Command `outlet`: offers a running session to tools that show or record it live."""

from typing import Annotated

import typer

from teletaction.commands.config_file import OwnConfigFile, own_config

app = typer.Typer()


@app.command("outlet")
def outlet_command(
    to: Annotated[str, typer.Option(help="Tool: foxglove, rerun or lsl.")],
    config: OwnConfigFile = None,
    host: Annotated[str | None, typer.Option(help="Address to listen at; by default 127.0.0.1.")] = None,
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Port; by default the tool's usual one. 0 takes a free one.")
    ] = None,
    open_to_network: Annotated[
        bool, typer.Option("--open-to-network", help="Let other hosts read the session, without a key.")
    ] = False,
) -> None:
    """Offer the session of a running operator site to a tool; --config is the site's file."""
    from functools import partial

    from common.config.site_models import OperatorConfig
    from common.process import run_process
    from teletaction.outlets.outlet import run_outlet

    run = partial(run_outlet, to=to, host=host, port=port, open_to_network=open_to_network)
    run_process("outlet", own_config(config, "operator"), OperatorConfig, run)
