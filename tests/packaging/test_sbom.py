"""The bill of materials names this version and each locked package that an image holds."""

import json
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.packaging.requirements import PROJECT
from tests.packaging.trim_sbom import trimmed
from tests.places import ROOT

IMAGE = {
    "python_version": "3.11",
    "python_full_version": "3.11.0",
    "sys_platform": "linux",
    "platform_machine": "x86_64",
    "platform_system": "Linux",
    "os_name": "posix",
    "platform_python_implementation": "CPython",
    "implementation_name": "cpython",
}
"""Environment of the image of the Dockerfile, for markers of requirements."""


@pytest.fixture(scope="module")
def bill() -> dict[str, Any]:
    read: dict[str, Any] = json.loads((ROOT / "teletaction" / "sbom.json").read_text("utf-8"))
    return read


def locked() -> dict[str, str]:
    """Version of each package of locks/run.txt that is installed on the image's platform."""
    lines = (ROOT / "locks" / "run.txt").read_text("utf-8").splitlines()
    wanted = [Requirement(line.rstrip(" \\")) for line in lines if line and not line.startswith((" ", "#", "-"))]
    return {
        canonicalize_name(each.name): str(each.specifier).removeprefix("==")
        for each in wanted
        if each.marker is None or each.marker.evaluate(IMAGE)
    }


def test_it_names_the_locked_packages_and_no_others(bill: dict[str, Any]) -> None:
    named = {canonicalize_name(each["name"]): each["version"] for each in bill["components"]}
    assert named == locked(), "run: make sbom"


def test_it_is_of_this_version(bill: dict[str, Any]) -> None:
    project = bill["metadata"]["component"]
    assert (project["name"], project["version"]) == (PROJECT["name"], PROJECT["version"]), "run: make sbom"


def test_each_package_has_a_licence(bill: dict[str, Any]) -> None:
    assert [each["name"] for each in bill["components"] if not each.get("licenses")] == []


def test_it_names_no_web_address_of_a_package(bill: dict[str, Any]) -> None:
    assert trimmed(bill) == bill, "run: make sbom"
