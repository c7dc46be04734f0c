"""Command `keys`: manages a site's key pair and its list of trusted keys."""

from pathlib import Path
from typing import Annotated

import typer

from teletaction.commands.as_json import Json, print_json

app = typer.Typer(name="keys", help="CurveZMQ keys of a site and the list of those it trusts.", no_args_is_help=True)

KeyFolder = Annotated[Path, typer.Option("--keys", help="Key folder of the site.")]


@app.command("init")
def keys_init(keys: KeyFolder) -> None:
    """Make a key pair and print the public key."""
    from common.link.keys import create_keys

    typer.echo(create_keys(keys))


@app.command("show")
def keys_show(keys: KeyFolder, as_json: Json = False) -> None:
    """Print the site's public key, its fingerprint, and the keys that it trusts."""
    from common.link.keys import TrustedKeys, fingerprint, load_keys

    own, owners = load_keys(keys), TrustedKeys(keys).owners()
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
    keys: KeyFolder,
    observer: Annotated[bool, typer.Option("--observer", help="The owner may watch the session only.")] = False,
) -> None:
    """Trust a public key under a name."""
    from common.link.keys import Role, TrustedKeys

    TrustedKeys(keys).trust(name, public_key, Role.OBSERVER if observer else Role.PARTNER)


@app.command("revoke")
def keys_revoke(name: str, keys: KeyFolder) -> None:
    """Revoke the keys of a name. A running site closes their connections within about a second."""
    from common.link.keys import TrustedKeys

    count = TrustedKeys(keys).revoke(name)
    typer.echo(f"revoked {count} key{'s' if count != 1 else ''} of {name}", err=True)
