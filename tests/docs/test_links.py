"""Links of README and pages lead somewhere; every page and picture is reached. The site's build checks the rest."""

from urllib.parse import unquote

import pytest

from studies.registry import STUDIES
from tests.docs.pages import NAMES, anchors, links
from tests.places import ROOT

TOP = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
PAGES = [*NAMES, *TOP, *(str(path.relative_to(ROOT)) for path in sorted((ROOT / "deploy").rglob("*.md")))]


@pytest.mark.parametrize("name", PAGES)
def test_every_link_has_a_target(name: str) -> None:
    for target, line in links(name):
        if "://" in target or target.startswith("mailto:"):
            continue
        path, _, anchor = unquote(target).partition("#")
        there = (ROOT / name).parent / path if path else ROOT / name
        assert there.exists(), f"{name}:{line}: {target}"
        assert there.resolve().is_relative_to(ROOT), f"{name}:{line}: {target} is outside"
        if anchor:
            assert anchor in anchors(str(there.resolve().relative_to(ROOT))), f"{name}:{line}: {target}"


def test_every_picture_is_shown() -> None:
    shown = {
        ((ROOT / name).parent / target).resolve()
        for name in NAMES
        for target, _ in links(name)
        if target.endswith((".png", ".svg"))
    }
    there = {path for kind in ("png", "svg") for path in (ROOT / "docs").rglob(f"*.{kind}")}
    assert there <= shown


def test_every_study_has_its_chart_explained() -> None:
    page = (ROOT / "docs" / "results.md").read_text("utf-8")
    assert [name for name in STUDIES if f"    teletaction study {name} --out DIR\n" not in page] == []
