"""Folders of the user by the XDG Base Directory Specification; explicit paths of a command take precedence."""

import os
from pathlib import Path

_PROGRAM = "teletaction"


def config_folder() -> Path:
    """Return the folder of configurations and keys: `$XDG_CONFIG_HOME/teletaction`, by default in `~/.config`.

    Raises:
        ValueError: there is no home directory.
    """
    return _folder("XDG_CONFIG_HOME", ".config")


def state_folder() -> Path:
    """Return the folder of sessions and their logs: `$XDG_STATE_HOME/teletaction`, by default in `~/.local/state`.

    Raises:
        ValueError: there is no home directory.
    """
    return _folder("XDG_STATE_HOME", ".local/state")


def make_private(folder: Path) -> None:
    """Create a folder, and each missing folder above it, for this user only (mode 0700).

    Raises:
        OSError: a folder cannot be created.
    """
    for each in reversed([folder, *folder.parents]):
        if not each.exists():
            each.mkdir(mode=0o700, exist_ok=True)


def _folder(variable: str, default: str) -> Path:
    given = Path(os.environ.get(variable, ""))
    if given.is_absolute():  # the specification has a relative path ignored
        return given / _PROGRAM
    try:
        return Path.home() / default / _PROGRAM
    except RuntimeError:
        raise ValueError(f"no home directory for {_PROGRAM}'s files: set {variable}, or give their path") from None
