"""Command `metrics`: serves figures of running processes to Prometheus."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer()


@app.command("metrics")
def metrics_command(
    status: Annotated[list[Path], typer.Option("--status", help="Status file of a process; once for each.")],
    listen: Annotated[str, typer.Option(help="HOST:PORT to serve.")] = "127.0.0.1:9634",
    token_file: Annotated[
        Path | None, typer.Option(help="File (mode 0600) with the token that a request must carry.")
    ] = None,
) -> None:
    """Serve the figures of running processes to Prometheus. Only their status files are read."""
    from common.logs import log_to_stderr
    from common.process import StopSignal

    try:
        from teletaction.metrics.metrics import StatusCollector
        from teletaction.metrics.metrics_server import MetricsServer, read_token
    except ModuleNotFoundError as missing:
        raise ValueError(f"metrics need {missing.name}: install `teletaction[metrics]`") from None

    token = None if token_file is None else read_token(token_file)
    with MetricsServer(listen, StatusCollector(status), token) as server:
        log_to_stderr("metrics")
        server.serve(StopSignal())
