"""Source distribution and wheel hold what they must; installed alone, the demo runs from an empty folder."""

import json
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import dataclass
from email.parser import Parser
from importlib.metadata import distribution
from pathlib import Path

import pytest

from tests.packaging.requirements import PROJECT, ROOMS, closure
from tests.places import ROOT

pytestmark = [pytest.mark.pages, pytest.mark.timeout(600)]

VERSION: str = PROJECT["version"]
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check")
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PIP_", "VIRTUAL_"))}


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


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    if not (ROOT / ".git").exists():
        pytest.skip("only a checkout knows which files are its own")
    folder = tmp_path_factory.mktemp("built")
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


def test_the_source_distribution_holds_the_repository(built: Built) -> None:
    with tarfile.open(built.sdist) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    of_this_place = {name for name in built.tracked if name.startswith(".")}
    assert built.tracked - of_this_place - held == set()


def test_the_wheel_holds_all_data_and_nothing_else(built: Built) -> None:
    with zipfile.ZipFile(built.wheel) as wheel:
        held = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert held == {name for name in built.tracked if name.startswith(tuple(f"{room}/" for room in ROOMS))}


def test_the_wheel_has_its_metadata(built: Built) -> None:
    info = f"teletaction-{VERSION}.dist-info"
    with zipfile.ZipFile(built.wheel) as wheel:
        said = Parser().parsestr(wheel.read(f"{info}/METADATA").decode())
        assert wheel.read(f"{info}/licenses/LICENSE") == (ROOT / "LICENSE").read_bytes()
    assert (said["Version"], said["License-Expression"]) == (VERSION, "MIT")
    assert said["Summary"]
    assert said["Description-Content-Type"] == "text/markdown"


def test_installed_alone_the_demo_runs_from_an_empty_folder(built: Built, tmp_path: Path) -> None:
    # What it requires, and what that requires, is lent from here; nothing else is there, whatever else is here.
    empty = tmp_path / "empty"
    empty.mkdir()
    python = environment(tmp_path / "clean")
    (site,) = (tmp_path / "clean" / "lib").glob("python*/site-packages")
    for name in closure(PROJECT["dependencies"]):
        lend(name, site)
    run(*PIP, "--python", python, "install", "--no-deps", built.wheel, folder=tmp_path)
    run(*PIP, "--python", python, "check", folder=tmp_path)
    teletaction = python.parent / "teletaction"
    run(teletaction, "demo", "--headless", "--seconds", 3, "--fingers", 1, "--out", "out", folder=empty)
    summary = json.loads((empty / "out" / "summary.json").read_text("utf-8"))
    assert summary["faults"] == []
    assert "<html" in (empty / "out" / "report.html").read_text("utf-8")
    assert "foam" in run(teletaction, "scene", "check", "paper_textures", folder=empty)
    done = run(python, "-c", "from common.version import *; print(software_version())", folder=empty)
    assert done.strip() == VERSION
