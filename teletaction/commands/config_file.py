"""Defines the option that names a process's configuration file, and the file that it has by default."""

from pathlib import Path
from typing import Annotated

import typer

from common.files.user_folders import config_folder

ConfigFile = Annotated[Path, typer.Option("--config", help="TOML file of this process.")]
OwnConfigFile = Annotated[
    Path | None,
    typer.Option("--config", help="TOML file of this process; by default its file in ~/.config/teletaction."),
]


def own_config(given: Path | None, *names: str) -> Path:
    """Return the given file, or else the first of the user's files `NAME.toml` that exists.

    Raises:
        ValueError: no file is given, and none exists; the message names the option and the files.
    """
    if given is not None:
        return given
    files = [config_folder() / f"{name}.toml" for name in names]
    found = next((file for file in files if file.exists()), None)
    if found is None:
        raise ValueError(f"no configuration: give --config FILE, or write {' or '.join(map(str, files))}")
    return found
