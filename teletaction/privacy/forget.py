"""Deletes what the project has written about an examination, and nothing else."""

import json
import os
import stat
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from common.files.private_file import refuse_link
from teletaction.privacy.project_files import kind_of

FORGOTTEN = "forgotten.jsonl"
"""List of deletions in each folder: one line with time, reason, and name and size of each file."""
_DAY_S = 86_400.0


@dataclass(frozen=True, slots=True)
class Doomed:
    """A file to delete: its path, its kind and its size, bytes."""

    path: Path
    kind: str
    size: int


@dataclass(slots=True)
class Choice:
    """Files of a folder.

    Attributes:
        folder: the folder, in which the deletion is noted.
        doomed: files to delete.
        kept: path of each file that stays, and why.
    """

    folder: Path
    doomed: list[Doomed] = field(default_factory=list)
    kept: list[tuple[Path, str]] = field(default_factory=list)


def choose(paths: Sequence[Path], now_s: float, older_than_days: float | None = None) -> list[Choice]:
    """Return the files to delete and those to keep, by folder. No link is followed.

    Args:
        paths: files, or folders with everything in them.
        now_s: present time, s since 1970.
        older_than_days: keep files whose last change is younger, days; by default age does not count.

    Raises:
        ValueError: a path does not exist or is a link.
        OSError: a folder cannot be read.
    """
    chosen: dict[Path, Choice] = {}
    seen: set[Path] = set()
    for given in paths:
        if given.is_symlink():
            raise ValueError(f"{given}: is a symbolic link; name the folder or file itself")
        if not given.exists():
            raise ValueError(f"{given}: no such file or folder")
        root = given if given.is_dir() else given.parent
        choice = chosen.setdefault(root, Choice(root))
        for path in _files(given) if given.is_dir() else [given]:
            real = path.parent.resolve() / path.name
            if path.name == FORGOTTEN or real in seen:
                continue
            seen.add(real)
            _judge(path, choice, now_s, older_than_days)
    return list(chosen.values())


def _files(folder: Path) -> Iterator[Path]:
    """Yield everything but folders below a folder, in order; links are not followed."""

    def refuse(error: OSError) -> None:
        raise error

    for inside, folders, names in os.walk(folder, onerror=refuse, followlinks=False):
        links = [name for name in folders if (Path(inside) / name).is_symlink()]
        folders[:] = sorted(set(folders) - set(links))
        yield from (Path(inside) / name for name in sorted([*names, *links]))


def _judge(path: Path, choice: Choice, now_s: float, older_than_days: float | None) -> None:
    status = path.lstat()
    if stat.S_ISLNK(status.st_mode):
        choice.kept.append((path, "a link"))
    elif (kind := kind_of(path)) is None:
        choice.kept.append((path, "forget deletes no such file"))
    elif older_than_days is not None and now_s - status.st_mtime < older_than_days * _DAY_S:
        choice.kept.append((path, f"changed within {older_than_days:g} days"))
    else:
        choice.doomed.append(Doomed(path, kind, status.st_size))


def forget(choice: Choice, why: str) -> None:
    """Delete the files of a choice and add a line to the folder's FORGOTTEN.

    Raises:
        OSError: a file cannot be deleted, or the deletion not be noted; those deleted before are noted.
    """
    gone: list[Doomed] = []
    note = choice.folder / FORGOTTEN
    refuse_link(note)
    try:
        for doomed in choice.doomed:
            doomed.path.unlink()
            gone.append(doomed)
    finally:
        if gone:
            _note(note, gone, why)


def _note(note: Path, gone: Sequence[Doomed], why: str) -> None:
    line = {
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "why": why,
        "files": [
            {"name": str(each.path.relative_to(note.parent)), "kind": each.kind, "bytes": each.size} for each in gone
        ],
    }
    number = os.open(note, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
    with open(number, "w", encoding="utf-8", errors="backslashreplace") as file:
        file.write(json.dumps(line) + "\n")
        file.flush()
        os.fsync(file.fileno())
