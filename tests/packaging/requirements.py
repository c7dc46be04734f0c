"""Lists the project's requirements and their dependencies on this machine."""

import tomllib
from collections.abc import Iterator
from importlib.metadata import requires

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.places import ROOT

_PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PROJECT = _PYPROJECT["project"]
EXTRAS: dict[str, list[str]] = PROJECT["optional-dependencies"]
GROUPS: dict[str, list[str]] = _PYPROJECT["dependency-groups"]
EXPORTS = ("dicom", "pandas", "parquet", "rerun", "foxglove", "lsl", "quality")
"""Extras of large packages, which only tests of exports install."""
ROOMS = ("common", "remote_site", "operator_site", "sim_sensors", "teletaction", "studies", "benchmarks", "robustness")


def names(requirements: list[str]) -> set[str]:
    """The packages that requirements name."""
    return {canonicalize_name(Requirement(line).name) for line in requirements}


def closure(wanted: list[str]) -> Iterator[str]:
    """All packages that these requirements bring along, themselves included."""
    waiting, seen = [Requirement(line) for line in wanted], set[tuple[str, frozenset[str]]]()
    while waiting:
        requirement = waiting.pop()
        name, extras = canonicalize_name(requirement.name), frozenset(requirement.extras)
        if (name, extras) in seen:
            continue
        seen.add((name, extras))
        yield name
        for line in requires(name) or ():
            further = Requirement(line)
            if further.marker is None or any(further.marker.evaluate({"extra": extra}) for extra in ("", *extras)):
                waiting.append(further)
