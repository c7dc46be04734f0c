"""`session`: what a person at a running site asks of it, through its desk."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from common.files.printable import printable
from teletaction.commands.config_file import ConfigFile
from teletaction.commands.failed import Failed

if TYPE_CHECKING:
    from common.link.keys import KeyPair

app = typer.Typer(name="session", help="What a person at a running site asks of it.", no_args_is_help=True)


@app.command("status")
def session_status(config: ConfigFile) -> None:
    """Print what a running site says of its session, as JSON."""
    from common.faults.fault import read_fault
    from common.faults.texts import fault_figures

    told = _ask_desk(config, "status")
    for name in {"fault", "remote_fault"} & told.keys():
        told[name] = fault_figures(read_fault(told[name]))
    typer.echo(json.dumps(told))


@app.command("engage")
def session_engage(config: ConfigFile) -> None:
    """Ask for outputs to act, at the operator's site; both sites must agree."""
    _ask_desk(config, "engage")


@app.command("disengage")
def session_disengage(config: ConfigFile) -> None:
    """Bring all outputs to neutral."""
    _ask_desk(config, "disengage")


@app.command("estop")
def session_estop(config: ConfigFile) -> None:
    """Emergency stop; waits for the devices to confirm and prints what they said."""
    from common.link.local_control import stop_from_desk

    outcome = stop_from_desk(*_desk(config))
    typer.echo(printable(outcome))
    if "not confirmed" in outcome:
        raise Failed(outcome)


@app.command("clear")
def session_clear(config: ConfigFile) -> None:
    """Clear a latched fault, at both sites where that may be done from here; nothing moves until engaged again."""
    from common.link.local_control import clear_from_desk
    from common.link.session_state import Refused

    try:
        clear_from_desk(*_desk(config))
    except Refused as refusal:
        raise Failed(f"clear: {refusal}") from None


@app.command("note")
def session_note(text: str, config: ConfigFile) -> None:
    """Write a note into the session's recording, at the operator's site."""
    _ask_desk(config, "annotate", {"text": text})


def _desk(config: Path) -> "tuple[int, KeyPair]":
    from common.config import load_site
    from common.link.keys import load_keys

    site = load_site(config)
    return site.desk_port, load_keys(site.link.keys)


def _ask_desk(config: Path, verb: str, details: dict[str, object] | None = None) -> dict[str, object]:
    from common.link.local_control import ask_desk
    from common.link.session_state import Refused

    try:
        return ask_desk(*_desk(config), verb, details)
    except Refused as refusal:
        raise Failed(f"{verb}: {refusal}") from None
