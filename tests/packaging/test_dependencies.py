"""Every dependency has its reason and its licence on one page, is pinned, and is what is imported."""

import ast
import re
import sys
from importlib.metadata import PackageNotFoundError, distribution, packages_distributions

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.packaging.requirements import EXTRAS, PROJECT, ROOMS, ROOT, closure, names

USERS = ("console", "metrics", "studies", "dask")
"""Extras with which somebody may run or pass on the project; the others are for working on it."""

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
    "hypothesis": "MPL-2.0",
    "pathspec": "Mozilla Public License 2.0 (MPL 2.0)",
}
"""Others, each looked at: used unchanged as a library, which these licences allow to programs of any licence."""
UNSTATED = {"axe-playwright-python"}
"""Says nothing in its metadata; MIT by its repository. Only for tests in a browser."""


DIRECT = names(PROJECT["dependencies"]).union(*(names(lines) for lines in EXTRAS.values()))


def rows() -> dict[str, tuple[str, str]]:
    """Reason and licence of each package on the page."""
    page = (ROOT / "docs" / "dependencies.md").read_text("utf-8")
    found = re.findall(r"(?m)^\| ([\w.-]+) \| (.+?) \| (.+?) \|$", page)
    return {canonicalize_name(name): (why, licence) for name, why, licence in found if name != "package"}


def pins() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    pairs = [line.split("==") for line in lines if line and not line.startswith("#")]
    return {canonicalize_name(name): version for name, version in pairs}


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


def test_the_page_says_the_licences_that_the_packages_say() -> None:
    for name, (_, told) in rows().items():
        try:
            said = licences(name)
        except PackageNotFoundError:
            continue
        if name not in UNSTATED:
            assert any(part.split()[0].split("-")[0] in told for part in said), f"{name}: {said}, told as {told}"


@pytest.mark.parametrize("extra", ["", *EXTRAS])
def test_everything_may_be_passed_on_with_the_project(extra: str) -> None:
    wanted = EXTRAS[extra] if extra else PROJECT["dependencies"]
    found = set(closure(installed(wanted)))
    assert found or not wanted or extra not in ("", *USERS)
    for name in found - (UNSTATED if extra and extra not in USERS else set()):
        parts = licences(name)
        assert NOTED.get(name) in parts or all(part.startswith(PERMISSIVE) for part in parts), f"{name}: {parts}"


def test_everything_that_is_installed_is_pinned() -> None:
    wanted = [*PROJECT["dependencies"], *(line for name in EXTRAS if name != "browser" for line in EXTRAS[name])]
    assert set(closure(installed(wanted))) <= pins().keys()


def test_what_is_imported_is_what_is_required() -> None:
    distributions = packages_distributions()
    allowed = names(PROJECT["dependencies"]).union(*(names(EXTRAS[extra]) for extra in USERS))
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
