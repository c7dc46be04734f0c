"""Option `--key` of the commands that read recordings."""

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from common.privacy.key_variable import KEY_VARIABLE, given_key


def _use(context: typer.Context, key: Path | None) -> Path | None:
    """Give the key to the command and to its processes until the command ends."""
    if key is not None:
        given = ExitStack()
        given.enter_context(given_key(key))
        context.call_on_close(given.close)
    return key


Key = Annotated[
    Path | None,
    typer.Option(
        "--key", callback=_use, help=f"Secret key's file for encrypted recordings; by default that of ${KEY_VARIABLE}."
    ),
]
"""The option; its value is in the environment while the command runs."""
