"""Source distribution and wheel hold what they must; installed alone, the demo runs from an empty folder."""

import json
import tarfile
import zipfile
from email.parser import Parser
from pathlib import Path

import pytest

from tests.packaging.requirements import PROJECT, ROOMS
from tests.packaging.wheel import VERSION, Built, install, run
from tests.places import ROOT

pytestmark = [pytest.mark.pages, pytest.mark.timeout(600)]


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
    empty = tmp_path / "empty"
    empty.mkdir()
    python = install(built, tmp_path, PROJECT["dependencies"])
    teletaction = python.parent / "teletaction"
    run(teletaction, "demo", "--headless", "--seconds", 3, "--fingers", 1, "--out", "out", folder=empty)
    summary = json.loads((empty / "out" / "summary.json").read_text("utf-8"))
    assert summary["faults"] == []
    assert "<html" in (empty / "out" / "report.html").read_text("utf-8")
    assert "foam" in run(teletaction, "scene", "check", "paper_textures", folder=empty)
    done = run(python, "-c", "from common.version import *; print(software_version())", folder=empty)
    assert done.strip() == VERSION
