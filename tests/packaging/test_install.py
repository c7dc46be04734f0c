"""Source distribution and wheel hold what they must; installed alone, the demo runs from an empty folder."""

import json
import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from dataclasses import dataclass
from email.parser import Parser
from pathlib import Path

import pytest

pytestmark = [pytest.mark.session, pytest.mark.timeout(600)]

ROOT = Path(__file__).parents[2]
ROOMS = ("common", "remote_site", "operator_site", "sim_sensors", "teletaction", "studies")
VERSION: str = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PIP_", "VIRTUAL_"))}


def run(*words: object, folder: Path) -> str:
    """Run a command that has to succeed; what it printed."""
    told = subprocess.run(
        [str(word) for word in words], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, check=False
    )
    assert told.returncode == 0, told.stdout + told.stderr
    return told.stdout


@dataclass(frozen=True)
class Built:
    """What was made of the repository's files: the two distributions, and a wheel made from the first."""

    tracked: set[str]
    sdist: Path
    wheel: Path
    wheel_of_sdist: Path
    pip: Path


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    folder = tmp_path_factory.mktemp("built")
    source = folder / "source"
    tracked = run("git", "ls-files", folder=ROOT).splitlines()
    for name in tracked:
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, source / name)
    run(sys.executable, "-m", "venv", folder / "builder", folder=folder)
    pip = folder / "builder" / "bin" / "pip"
    run(pip, "install", "setuptools>=77", folder=folder)
    backend = f"from setuptools import build_meta; build_meta.build_sdist({str(folder)!r})"
    run(folder / "builder" / "bin" / "python", "-c", backend, folder=source)
    sdist = folder / f"teletaction-{VERSION}.tar.gz"
    made = []
    for what, where in ((source, "from-source"), (sdist, "from-sdist")):
        run(pip, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", folder / where, what, folder=folder)
        made += (folder / where).glob("*.whl")
    return Built(set(tracked), sdist, made[0], made[1], pip)


def test_the_source_distribution_holds_the_repository(built: Built) -> None:
    with tarfile.open(built.sdist) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    of_this_place = {name for name in built.tracked if name.startswith(".")}
    assert built.tracked - of_this_place - held == set()


def test_the_wheel_holds_all_data_and_nothing_else(built: Built) -> None:
    with zipfile.ZipFile(built.wheel) as wheel:
        held = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert held == {name for name in built.tracked if name.startswith(tuple(f"{room}/" for room in ROOMS))}


def test_the_wheel_says_what_it_is(built: Built) -> None:
    info = f"teletaction-{VERSION}.dist-info"
    with zipfile.ZipFile(built.wheel) as wheel:
        said = Parser().parsestr(wheel.read(f"{info}/METADATA").decode())
        assert wheel.read(f"{info}/licenses/LICENSE") == (ROOT / "LICENSE").read_bytes()
    assert (said["Version"], said["License-Expression"]) == (VERSION, "MIT")
    assert said["Summary"]
    assert said["Description-Content-Type"] == "text/markdown"


def test_a_wheel_of_the_source_distribution_is_the_same(built: Built) -> None:
    def content(path: Path) -> dict[str, int]:
        with zipfile.ZipFile(path) as wheel:
            return {entry.filename: entry.CRC for entry in wheel.infolist()}

    assert content(built.wheel) == content(built.wheel_of_sdist)


def test_installed_alone_the_demo_runs_from_an_empty_folder(built: Built, tmp_path: Path) -> None:
    clean, empty = tmp_path / "clean", tmp_path / "empty"
    empty.mkdir()
    run(sys.executable, "-m", "venv", "--without-pip", clean, folder=tmp_path)
    python = clean / "bin" / "python"
    constraints = ROOT / "constraints.txt"
    install = ("install", "--only-binary=:all:", "--no-compile", "-c", constraints, built.wheel_of_sdist)
    run(built.pip, "--python", python, *install, folder=tmp_path)
    teletaction = clean / "bin" / "teletaction"
    run(teletaction, "demo", "--headless", "--seconds", 4, "--fingers", 1, "--out", "out", folder=empty)
    summary = json.loads((empty / "out" / "summary.json").read_text("utf-8"))
    assert summary["faults"] == []
    assert "<html" in (empty / "out" / "report.html").read_text("utf-8")
    assert "foam" in run(teletaction, "scene", "check", "paper_textures", folder=empty)
    told = run(python, "-c", "from common.software_version import *; print(software_version())", folder=empty)
    assert told.strip() == VERSION
    for room in ("remote_site", "operator_site", "sim_sensors", "teletaction"):
        run(python, "-m", room, "--help", folder=empty)
