"""Command `keys`: manages a site's key pair and its list of trusted keys."""

from pathlib import Path
from typing import Annotated

import typer

from common.files.user_folders import config_folder, make_private
from teletaction.commands.as_json import Json, print_json

app = typer.Typer(name="keys", help="CurveZMQ keys of a site and the list of those it trusts.", no_args_is_help=True)

KeyFolder = Annotated[
    Path | None, typer.Option("--keys", help="Key folder of the site; by default ~/.config/teletaction/keys.")
]


@app.command("init")
def keys_init(keys: KeyFolder = None) -> None:
    """Make a key pair and print the public key."""
    from common.link.keys import create_keys

    typer.echo(create_keys(_folder(keys, make=True)))


@app.command("show")
def keys_show(keys: KeyFolder = None, as_json: Json = False) -> None:
    """Print the site's public key, its fingerprint, and the keys that it trusts."""
    from common.link.keys import TrustedKeys, fingerprint, load_keys

    folder = _folder(keys)
    own, owners = load_keys(folder), TrustedKeys(folder).owners()
    if as_json:
        trusted = [{"name": owner.name, "role": owner.role.value, "key": key} for key, owner in owners.items()]
        print_json({"own": own.public, "trusted": trusted})
        return
    typer.echo(f"own {fingerprint(own.public)} {own.public}")
    for key, owner in owners.items():
        typer.echo(f"trusted {owner.name} ({owner.role.value}) {fingerprint(key)} {key}")


@app.command("trust")
def keys_trust(
    name: str,
    public_key: str,
    keys: KeyFolder = None,
    observer: Annotated[bool, typer.Option("--observer", help="The owner may watch the session only.")] = False,
) -> None:
    """Trust a public key under a name. The site must have a key of its own."""
    from common.link.keys import Role, Trusted, TrustedKeys, check_public_key, fingerprint, load_keys

    now = Trusted(name, Role.OBSERVER if observer else Role.PARTNER)
    folder = _folder(keys)
    check_public_key(public_key)
    load_keys(folder)
    before = TrustedKeys(folder).trust(name, public_key, now.role)
    if before not in (None, now):
        was, has = (f"{owner.name} ({owner.role.value})" for owner in (before, now))
        typer.echo(f"changed {fingerprint(public_key)}: was {was}, is {has}", err=True)


@app.command("revoke")
def keys_revoke(name: str, keys: KeyFolder = None) -> None:
    """Revoke the keys of a name. A running site closes their connections within about a second."""
    from common.link.keys import TrustedKeys

    count = TrustedKeys(_folder(keys)).revoke(name)
    typer.echo(f"revoked {count} key{'s' if count != 1 else ''} of {name}", err=True)


@app.command("secret")
def keys_secret(file: Path) -> None:
    """Make the secret of a room, for a rendezvous and both ends of a tunnel over it."""
    from teletaction.tunnel.room_secret import create_secret

    create_secret(file)


def _folder(given: Path | None, *, make: bool = False) -> Path:
    """Return the given key folder, or else the user's; `make` creates the folders above the user's."""
    if given is not None:
        return given
    folder = config_folder()
    if make:
        make_private(folder)
    return folder / "keys"
