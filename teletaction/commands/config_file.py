"""Defines the option that names a process's configuration file."""

from pathlib import Path
from typing import Annotated

import typer

ConfigFile = Annotated[Path, typer.Option("--config", help="TOML file of this process.")]
