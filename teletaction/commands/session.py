"""Command `session`: sends local commands of a person to a running site."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from common.files.printable import printable
from teletaction.commands.config_file import own_config
from teletaction.commands.failed import Failed

if TYPE_CHECKING:
    from common.link.keys import KeyPair

SiteFile = Annotated[
    Path | None,
    typer.Option(
        "--config",
        help="TOML file of a running site; by default operator.toml, or else remote.toml, in ~/.config/teletaction.",
    ),
]

app = typer.Typer(name="session", help="Commands of a person to a running site.", no_args_is_help=True)


@app.command("status")
def session_status(config: SiteFile = None) -> None:
    """Print the status of a running site's session, as JSON."""
    from common.faults.fault import read_fault
    from common.faults.texts import fault_figures

    status = _ask_desk(config, "status")
    for name in {"fault", "remote_fault"} & status.keys():
        status[name] = fault_figures(read_fault(status[name]))
    typer.echo(json.dumps(status))


@app.command("engage")
def session_engage(config: SiteFile = None) -> None:
    """Request at the operator's site that outputs act; both sites must agree."""
    _ask_desk(config, "engage")


@app.command("disengage")
def session_disengage(config: SiteFile = None) -> None:
    """Bring all outputs to neutral."""
    _ask_desk(config, "disengage")


@app.command("estop")
def session_estop(config: SiteFile = None) -> None:
    """Stop in an emergency, wait until the devices confirm, and print the outcome."""
    from common.link.local_control import stop_from_desk

    outcome = stop_from_desk(*_desk(config))
    typer.echo(printable(outcome))
    if "not confirmed" in outcome:
        raise Failed(outcome)


@app.command("clear")
def session_clear(config: SiteFile = None) -> None:
    """Clear a latched fault, at both sites if this site may; nothing moves until engaged again."""
    from common.link.local_control import clear_from_desk
    from common.link.session_state import Refused

    try:
        clear_from_desk(*_desk(config))
    except Refused as refusal:
        raise Failed(f"clear: {refusal}") from None


@app.command("restore-force")
def session_restore_force(config: SiteFile = None) -> None:
    """End the force limit that follows the patient's pain, at the remote site, after asking the patient."""
    _ask_desk(config, "restore_force")


VoiceFile = Annotated[
    Path | None,
    typer.Option("--config", help="TOML file of a running voice; by default voice.toml in ~/.config/teletaction."),
]


@app.command("mute-voice")
def session_mute_voice(config: VoiceFile = None) -> None:
    """Mute the remote site's microphone."""
    _ask_voice(config, "mute_voice")


@app.command("unmute-voice")
def session_unmute_voice(config: VoiceFile = None) -> None:
    """Open the remote site's microphone again."""
    _ask_voice(config, "unmute_voice")


@app.command("note")
def session_note(text: str, config: SiteFile = None) -> None:
    """Write a note into the session's recording, at the operator's site."""
    _ask_desk(config, "annotate", {"text": text})


def _desk(config: Path | None) -> "tuple[int, KeyPair]":
    from common.config.file import load_site
    from common.link.keys import load_keys

    site = load_site(own_config(config, "operator", "remote"))
    return site.desk_port, load_keys(site.link.keys)


def _ask_desk(config: Path | None, verb: str, details: dict[str, object] | None = None) -> dict[str, object]:
    return _ask(_desk(config), verb, details)


def _ask_voice(config: Path | None, verb: str) -> None:
    from common.config.file import load_config
    from common.config.stream_models import VoiceConfig
    from common.link.keys import load_keys

    voice = load_config(own_config(config, "voice"), VoiceConfig)
    _ask((voice.desk_port, load_keys(voice.link.keys)), verb)


def _ask(desk: "tuple[int, KeyPair]", verb: str, details: dict[str, object] | None = None) -> dict[str, object]:
    from common.link.local_control import ask_desk
    from common.link.session_state import Refused

    try:
        return ask_desk(*desk, verb, details)
    except Refused as refusal:
        command = "note" if verb == "annotate" else verb.replace("_", "-")
        raise Failed(f"{command}: {refusal}") from None
