"""Refuses a file that is named twice, where its content would count twice."""

import os
from collections.abc import Sequence
from pathlib import Path


def require_each_once(paths: Sequence[Path]) -> None:
    """Raise ValueError where two paths, or links, lead to one file."""
    files = [os.path.realpath(path) for path in paths]
    for number, path in enumerate(paths):
        if files[number] in files[:number]:
            raise ValueError(f"{path}: is named twice")
