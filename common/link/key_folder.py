"""Reads the files of a key folder and refuses files that another user could change."""

import os
import pwd
import stat
from pathlib import Path

from common.files.printable import printable
from common.files.whole_file import read_whole


class KeyProblem(ValueError):
    """An unusable key folder; the message names the file and the remedy."""


def read_own(path: Path, *, secret: bool = False) -> bytes:
    """Return the content of a file of a key folder.

    Args:
        path: the file; a link is followed, and its target is checked.
        secret: whether reading by others is refused, too.

    Raises:
        FileNotFoundError: the file does not exist.
        KeyProblem: the file cannot be read, or a user other than this process's user and root may change it or its
            folder.
    """
    try:
        check_folder(path.parent)
        content, status = read_whole(path)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise KeyProblem(f"{shown(path)}: {error.strerror}") from None
    _check_owner(path, status)
    mode = stat.S_IMODE(status.st_mode)
    if mode & 0o077 and secret:
        raise KeyProblem(f"{shown(path)}: mode {mode:04o} lets others read it; `chmod 600` it or make a new key")
    if mode & 0o022:
        raise KeyProblem(f"{shown(path)}: mode {mode:04o} lets others change it; `chmod go-w` it and check it")
    return content


def check_folder(folder: Path) -> None:
    """Raise KeyProblem where another user could replace a file in `folder`; OSError where it does not exist."""
    try:
        status = folder.stat()
    except ValueError:
        raise KeyProblem(f"{shown(folder)}: not the name of a folder") from None
    _check_owner(folder, status)
    if status.st_mode & 0o022 and not status.st_mode & stat.S_ISVTX:
        mode = stat.S_IMODE(status.st_mode)
        raise KeyProblem(f"{shown(folder)}: mode {mode:04o} lets others change it; `chmod go-w` it and check its files")


def shown(path: Path) -> str:
    """Return a path as one printable line."""
    return printable(str(path))


def _check_owner(path: Path, status: os.stat_result) -> None:
    me = os.geteuid()
    if status.st_uid not in (me, 0):
        raise KeyProblem(
            f"{shown(path)}: belongs to {_user(status.st_uid)} and this process to {_user(me)}: "
            f"run as that user, or `chown {_user(me)}` it and check it"
        )


def _user(number: int) -> str:
    try:
        return pwd.getpwuid(number).pw_name
    except KeyError:
        return f"user {number}"
