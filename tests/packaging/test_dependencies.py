"""Every dependency has its reason and its licence on one page, is pinned, and is what is imported."""

import ast
import re
import sys
from importlib.metadata import PackageNotFoundError, distribution, packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.packaging.requirements import EXPORTS, EXTRAS, GROUPS, PROJECT, ROOMS, closure, names
from tests.places import ROOT

PERMISSIVE = (
    *("MIT", "MIT-CMU", "BSD", "Apache", "ISC", "Python Software Foundation", "PSF-2.0", "0BSD", "Zlib", "CC0-1.0"),
    "DFSG approved",
)
"""May be passed on with the project under its own licence; matched at the beginning."""
NOTED = {
    "python-can": "LGPL-3.0-only",
    "certifi": "Mozilla Public License 2.0 (MPL 2.0)",
    "corncobs": "MPL-2.0",
    "docutils": "Public Domain",  # but for parts under BSD, and an editor's mode under GPL that is not installed
    "fqdn": "MPL-2.0",
    "hypothesis": "MPL-2.0",
    "pathspec": "Mozilla Public License 2.0 (MPL 2.0)",
}
"""Others, each looked at: used unchanged as a library, which these licences allow to programs of any licence."""
UNSTATED = {"axe-playwright-python"}
"""Says nothing in its metadata; MIT by its repository. Only for tests in a browser."""


DIRECT = names(PROJECT["dependencies"]).union(*(names(lines) for lines in (*EXTRAS.values(), *GROUPS.values())))


def rows() -> dict[str, tuple[str, str]]:
    """Reason and licence of each package on the page."""
    page = (ROOT / "docs" / "dependencies.md").read_text("utf-8")
    found = re.findall(r"(?m)^\| ([\w.-]+) \| (.+?) \| (.+?) \|$", page)
    return {canonicalize_name(name): (why, licence) for name, why, licence in found if name != "package"}


def pins() -> dict[str, str]:
    return locked(ROOT / "constraints.txt")


def locked(path: Path) -> dict[str, str]:
    """Version of each package in a list of exact versions."""
    found = re.findall(r"(?m)^([\w.-]+)==([^\s;]+)", path.read_text("utf-8"))
    return {canonicalize_name(name): version for name, version in found}


def licences(name: str) -> list[str]:
    """What a package says its licence is, each part by itself."""
    metadata = distribution(name).metadata
    said = metadata.get("License-Expression")
    if said is None:
        classes = [line for line in metadata.get_all("Classifier") or () if line.startswith("License :: ")]
        said = " AND ".join(line.split(" :: ")[-1] for line in classes) or metadata.get("License") or ""
    return [part.strip(" ()") if part.count("(") != 1 else part.strip() for part in re.split(r" AND | OR ", said)]


def installed(requirements: list[str]) -> list[str]:
    """Those that are installed here: not every test is run with every extra."""
    found = []
    for line in requirements:
        try:
            distribution(Requirement(line).name)
        except PackageNotFoundError:
            continue
        found.append(line)
    return found


def test_every_dependency_has_a_reason_and_nothing_else_has() -> None:
    assert rows().keys() == DIRECT
    assert all(len(why.split()) >= 2 for why, _ in rows().values())


def test_the_page_has_the_licences_of_the_packages() -> None:
    for name, (_, stated) in rows().items():
        try:
            said = licences(name)
        except PackageNotFoundError:
            continue
        if name not in UNSTATED:
            assert any(part.split()[0].split("-")[0] in stated for part in said), f"{name}: {said}, stated as {stated}"


@pytest.mark.parametrize("part", ["", *EXTRAS, *GROUPS])
def test_every_licence_allows_distribution(part: str) -> None:
    wanted = {"": PROJECT["dependencies"], **EXTRAS, **GROUPS}[part]
    found = set(closure(installed(wanted)))
    assert found or part in GROUPS or part in EXPORTS
    for name in found - (UNSTATED if part in GROUPS else set()):
        parts = licences(name)
        assert NOTED.get(name) in parts or all(part.startswith(PERMISSIVE) for part in parts), f"{name}: {parts}"


def test_every_installed_package_is_pinned() -> None:
    parts = (*EXTRAS.values(), *GROUPS.values())
    wanted = [*PROJECT["dependencies"], *(line for part in parts for line in part)]
    assert set(closure(installed(wanted))) <= pins().keys()


@pytest.mark.parametrize("name", ["run", *GROUPS])
def test_a_lock_has_the_pinned_versions_with_their_hashes(name: str) -> None:
    path = ROOT / "locks" / f"{name}.txt"
    of_locks = {"run": {"console", "privacy"}, "exports": set(EXPORTS), "dev": EXTRAS.keys() - set(EXPORTS)}
    extras = of_locks.get(name, set())
    wanted = [*(line for extra in sorted(extras) for line in EXTRAS[extra]), *GROUPS.get(name, ())]
    wanted += PROJECT["dependencies"] if extras else ()
    assert names(wanted) | set(closure(installed(wanted))) <= locked(path).keys()
    assert locked(path).items() <= pins().items()
    entries = re.split(r"(?m)^(?=[\w.-]+==)", path.read_text("utf-8"))[1:]
    assert len(entries) == len(locked(path))
    assert all(re.search(r"--hash=sha256:[0-9a-f]{64}\b", entry) for entry in entries)
    assert "://" not in path.read_text("utf-8")


@pytest.mark.long
def test_imports_match_the_requirements() -> None:
    distributions = {"rerun": ["rerun-sdk"], "foxglove": ["foxglove-sdk"], **packages_distributions()}
    allowed = names(PROJECT["dependencies"]).union(*(names(EXTRAS[extra]) for extra in EXTRAS))
    imported: set[str] = set()
    for room in ROOMS:
        for path in (ROOT / room).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                if isinstance(node, ast.Import):
                    imported.update(alias.name.split(".")[0] for alias in node.names)
                elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    imported.add(node.module.split(".")[0])
    others = imported - set(sys.stdlib_module_names) - set(ROOMS)
    assert {canonicalize_name(name) for module in others for name in distributions.get(module, [module])} <= allowed
