"""The file with a room's secret, which only its owner can read."""

import secrets
from pathlib import Path
from shlex import quote

from common.files.private_file import create_private, discard
from common.link.key_folder import KeyProblem, read_own, shown

_LEAST = 32
"""Minimum length of a secret, characters."""


def create_secret(path: Path) -> None:
    """Make the file of a new room; raises KeyProblem where it exists or cannot be created."""
    try:
        file = create_private(path)
        try:
            with file:
                file.write(secrets.token_hex(_LEAST).encode() + b"\n")
        except OSError:
            discard(path)  # otherwise the next try finds part of a secret
            raise
    except OSError as error:
        raise KeyProblem(f"{shown(path)}: {error.strerror}") from None


def read_secret(path: Path) -> bytes:
    """Return the secret of a room from its file.

    Raises:
        KeyProblem: the file does not exist, others can read or change it, or the secret is too short.
    """
    try:
        secret = read_own(path, secret=True).strip()
    except FileNotFoundError:
        name = shown(path)
        raise KeyProblem(f"{name}: no such file: `teletaction keys secret {quote(name)}` makes it") from None
    if len(secret) < _LEAST:
        raise KeyProblem(f"{shown(path)}: the secret has {len(secret)} characters, at least {_LEAST} are needed")
    return secret
