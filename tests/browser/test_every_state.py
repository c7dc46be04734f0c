"""Every state, in both themes, at both sizes and at 200 % zoom: all fits, and axe finds nothing serious."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.browser.conftest import LIVE, SIZES, Open
from tests.browser.stage import Stage
from tests.browser.synthetic import SCENARIOS

pytestmark = [pytest.mark.console, pytest.mark.timeout(300)]

LOOK = Path(__file__).with_name("look.js").read_text("utf-8")


def axe_findings(page: Any) -> list[str]:
    """Serious and critical findings, with where they are."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")
    found = axe.Axe().run(page, options={"resultTypes": ["violations"]}).response["violations"]
    return [
        f"{one['id']}: {[node['target'] for node in one['nodes']]}"
        for one in found
        if one["impact"] in ("serious", "critical")
    ]


@pytest.mark.parametrize("theme", ["dark", "light"])
@pytest.mark.parametrize("size", SIZES)
def test_every_state_fits_and_is_accessible(
    stage: Stage, open_page: Open, picture_of: Callable[[Any, str], None], size: str, theme: str
) -> None:
    page = open_page("connected", SIZES[size], theme)
    wrong: dict[str, list[str]] = {}
    for name in SCENARIOS:
        if name == "silent":
            stage.show("engaged")
            page.reload()
            page.wait_for_selector("body[data-shown=engaged]")
            stage.show(name)
            page.wait_for_selector("body[data-shown=unknown]")
        else:
            shown = stage.show(name)
            page.reload()
            page.wait_for_selector(LIVE)
            assert page.evaluate("document.body.dataset.role") == shown.state["you"]["role"]
        page.wait_for_timeout(300)  # a round of the numbers, which are written four times a second
        found = page.evaluate(LOOK) + axe_findings(page)
        if found:
            wrong[name] = found
        picture_of(page, f"{name} {size} {theme}")
    assert wrong == {}


SHEETS = {
    "marking": ("engaged", ["f", "2", "ArrowRight"]),
    "noting": ("engaged", ["n"]),
    "help": ("engaged", ["?"]),
    "alarm list": ("fault", ["a"]),
    "details": ("engaged", ["d"]),
    "roughness": ("engaged", ["r"]),
    "stiffness": ("engaged", ["s"]),
    "material": ("engaged", ["m"]),
    "sure": ("engaged", ["u"]),
}


@pytest.mark.parametrize("theme", ["dark", "light"])
@pytest.mark.parametrize("size", SIZES)
def test_what_keys_open_fits_and_is_accessible(
    stage: Stage, open_page: Open, picture_of: Callable[[Any, str], None], size: str, theme: str
) -> None:
    page = open_page("engaged", SIZES[size], theme)
    wrong: dict[str, list[str]] = {}
    for name, (scenario, keys) in SHEETS.items():
        stage.show(scenario)
        page.reload()
        page.wait_for_selector(f"body[data-shown={scenario}]")
        for key in keys:
            page.keyboard.press(key)
        page.wait_for_timeout(300)  # a round of the numbers
        found = page.evaluate(LOOK) + axe_findings(page)
        if found:
            wrong[name] = found
        picture_of(page, f"{name} {size} {theme}")
    assert wrong == {}
