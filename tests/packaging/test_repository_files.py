"""The repository holds only files of kinds that belong where they are, so that scratch files are noticed."""

import pytest

from tests.packaging.wheel import run
from tests.places import ROOT

AT_THE_ROOT = frozenset(
    [
        ".dockerignore",
        ".editorconfig",
        ".env",
        ".gitignore",
        ".pre-commit-config.yaml",
        "CHANGELOG.md",
        "CITATION.cff",
        "CONTRIBUTING.md",
        "Dockerfile",
        "LICENSE",
        "MANIFEST.in",
        "Makefile",
        "README.md",
        "SECURITY.md",
        "constraints.txt",
        "docker-compose.yml",
        "pyproject.toml",
    ]
)
KINDS = {
    ".ci": "run",
    ".github": "yml",
    "benchmarks": "py toml",
    "common": "py dbc toml typed",
    "deploy": "md conf network rules service",
    "docker": "toml sh",
    "docs": "md json png svg py css html txt",
    "examples": "md py ipynb",
    "locks": "txt",
    "operator_site": "py js css html svg json txt typed",
    "remote_site": "py js css html json typed",
    "robustness": "py",
    "sim_sensors": "py toml npz typed",
    "studies": "py",
    "teletaction": "py json typed",
    "tests": "py js jsonl mcap ivf toml yml sh",
}
"""Endings of the files in each top-level folder. Add one here with the first file of a new kind."""
SCRATCH = ("scratch", "tmp", "temp_", "try_", "debug_", "out.", "log.", "old_")


def unexpected(names: list[str]) -> list[str]:
    """Tracked files that are in no known place, of no known kind, or named like a scratch file."""
    found = []
    for name in names:
        folder, _, rest = name.partition("/")
        file = name.rpartition("/")[2]
        known = file.rpartition(".")[2] in KINDS.get(folder, "").split() if rest else name in AT_THE_ROOT
        if not known or file.lower().startswith(SCRATCH):
            found.append(name)
    return found


@pytest.mark.parametrize("name", ["run.py", "notes/a.py", "studies/a.log", "tests/scratch_1.py", "docs/a.csv", "a/run"])
def test_a_scratch_file_is_found(name: str) -> None:
    assert unexpected(["README.md", name, ".ci/run"]) == [name]


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="only a checkout knows which files are its own")
def test_no_scratch_file_is_committed() -> None:
    assert unexpected(run("git", "ls-files", folder=ROOT).splitlines()) == []
