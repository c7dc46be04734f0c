"""The version stands in one place; changelog and licence agree with it."""

import re

from packaging.version import Version

from tests.packaging.requirements import PROJECT, ROOMS
from tests.places import ROOT

VERSION = Version(PROJECT["version"])


def test_no_file_repeats_the_version() -> None:
    said = re.compile(rf"(?<![\d.]){re.escape(PROJECT['version'])}(?![\d.])")
    files = [
        path
        for room in (*ROOMS, "docker", "deploy")
        for path in (ROOT / room).rglob("*")
        if path.suffix in {".py", ".toml", ".js"}
    ]
    files += [ROOT / "Dockerfile", ROOT / "docker-compose.yml"]
    assert [path for path in files if said.search(path.read_text("utf-8"))] == []


def test_the_changelog_begins_with_unreleased_changes() -> None:
    unreleased, *released = re.findall(r"(?m)^## \[(.+?)\]", (ROOT / "CHANGELOG.md").read_text("utf-8"))
    assert unreleased == "Unreleased"
    versions = [Version(heading) for heading in released]
    assert versions == sorted(set(versions), reverse=True)
    assert all(version <= VERSION for version in versions), "a release is newer than pyproject.toml says"


def test_the_citation_names_this_version() -> None:
    assert f"\nversion: {VERSION}\n" in (ROOT / "CITATION.cff").read_text("utf-8")


def test_the_licence_file_matches_the_declared_licence() -> None:
    assert PROJECT["license"] == "MIT"
    assert PROJECT["license-files"] == ["LICENSE"]
    assert (ROOT / "LICENSE").read_text("utf-8").startswith("MIT License\n")
