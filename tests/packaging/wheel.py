"""Builds source distribution and wheel, and installs the wheel where nothing else is."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from importlib.metadata import distribution
from pathlib import Path

from tests.packaging.requirements import PROJECT, closure
from tests.places import ROOT

VERSION: str = PROJECT["version"]
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check")
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PIP_", "VIRTUAL_"))}
ENVIRONMENT["MPLBACKEND"] = "agg"


def run(*words: object, folder: Path) -> str:
    """Run a command that has to succeed; what it printed."""
    done = subprocess.run(
        [str(word) for word in words], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@dataclass(frozen=True)
class Built:
    """What was made of the repository's files: a source distribution, and a wheel of that."""

    tracked: set[str]
    sdist: Path
    wheel: Path


def environment(folder: Path) -> Path:
    """A virtual environment with nothing in it; its Python."""
    run(sys.executable, "-m", "venv", "--without-pip", folder, folder=folder.parent)
    return folder / "bin" / "python"


def lend(name: str, site: Path) -> None:
    """Put a package of this environment into another one."""
    package = distribution(name)
    for top in {file.parts[0] for file in package.files or ()} - {"..", "__pycache__"}:
        if not (site / top).exists():
            (site / top).symlink_to(Path(str(package.locate_file(top))))


def build(folder: Path) -> Built:
    """Build the tracked files of the repository in `folder`."""
    source = folder / "source"
    tracked = run("git", "ls-files", folder=ROOT).splitlines()
    for name in tracked:
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, source / name)
    builder = environment(folder / "builder")
    run(*PIP, "--python", builder, "install", "setuptools>=77", folder=folder)
    backend = f"from setuptools import build_meta; build_meta.build_sdist({str(folder)!r})"
    run(builder, "-c", backend, folder=source)
    sdist = folder / f"teletaction-{VERSION}.tar.gz"
    alone = ("--no-deps", "--no-build-isolation", "--wheel-dir", folder / "wheel")
    run(*PIP, "--python", builder, "wheel", *alone, sdist, folder=folder)
    (wheel,) = (folder / "wheel").glob("*.whl")
    return Built(set(tracked), sdist, wheel)


def install(built: Built, folder: Path, requirements: list[str]) -> Path:
    """Install the wheel into a new environment, with these requirements lent from this one; its Python.

    What they require is lent, too; nothing else is there, whatever else is here.
    """
    python = environment(folder / "clean")
    (site,) = (folder / "clean" / "lib").glob("python*/site-packages")
    for name in closure(requirements):
        lend(name, site)
    run(*PIP, "--python", python, "install", "--no-deps", built.wheel, folder=folder)
    run(*PIP, "--python", python, "check", folder=folder)
    return python
