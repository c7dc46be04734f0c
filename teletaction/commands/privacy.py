"""Commands `encrypt`, `decrypt` and `forget`."""

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from teletaction.commands.key_option import Key

if TYPE_CHECKING:
    from teletaction.privacy.forget import Choice

app = typer.Typer()

_CUT = "{path}: was cut; {out} has everything up to its last whole part"


@app.command("encrypt")
def encrypt_command(
    file: Annotated[Path, typer.Argument(help="Recording or any other file.")],
    out: Annotated[Path, typer.Argument(help="File to write.")],
    recipient: Annotated[
        str, typer.Option("--for", help="Public key of the person who shall read it, or its file or key folder.")
    ],
    key: Key = None,
) -> None:
    """Encrypt a file for one person. An encrypted file is opened with --key and encrypted again."""
    from teletaction.privacy.encrypt import encrypt

    if not encrypt(file, out, recipient):
        typer.echo(_CUT.format(path=file, out=out), err=True)


@app.command("decrypt")
def decrypt_command(
    file: Annotated[Path, typer.Argument(help="Encrypted file.")],
    out: Annotated[Path, typer.Argument(help="File to write.")],
    key: Key = None,
) -> None:
    """Decrypt a file with your secret key."""
    from teletaction.privacy.encrypt import decrypt

    if not decrypt(file, out):
        typer.echo(_CUT.format(path=file, out=out), err=True)


@app.command("forget")
def forget_command(
    paths: Annotated[list[Path], typer.Argument(help="Folders of examinations, or files.")],
    older_than_days: Annotated[
        float | None, typer.Option(min=0.0, help="Delete only files whose last change is older, days.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Show what would be deleted, and delete nothing.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Delete without a question.")] = False,
) -> None:
    """Delete recordings, reports, exports and other files of this program; every other file is named and kept."""
    from teletaction.privacy.forget import choose, forget

    choices = choose(paths, time.time(), older_than_days)
    _show(choices)
    count = sum(len(choice.doomed) for choice in choices)
    if dry_run or not count:
        typer.echo(f"{count} files would be deleted" if count else "nothing to delete", err=True)
        return
    if not yes:
        if not sys.stdin.isatty():
            raise ValueError("forget: no terminal to ask at; give --yes to delete, or --dry-run to see what it would")
        typer.confirm(f"Delete {count} files? They cannot be brought back.", abort=True, err=True)
    why = "requested" if older_than_days is None else f"older than {older_than_days:g} days"
    for choice in choices:
        forget(choice, why)
    typer.echo(f"deleted {count} files", err=True)


def _show(choices: "Sequence[Choice]") -> None:
    for choice in choices:
        for doomed in choice.doomed:
            typer.echo(f"delete {doomed.path} ({doomed.kind}, {doomed.size} bytes)", err=True)
        for path, why in choice.kept:
            typer.echo(f"keep   {path} ({why})", err=True)
