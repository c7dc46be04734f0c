"""A telediagnosis session in the page, on a running demo: a lesion is found, the link is cut, all is played again."""

from collections.abc import Callable, Iterator
from importlib import resources
from typing import Any

import pytest

from common.scenes.scene import load_scene
from operator_site.console.examination.reporting import LONGEST_S
from tests.browser.live import NEUTRAL, aim, begin, end, engage, opened, state_of
from tests.browser.running_demo import Demo, running
from tests.browser.test_every_state import LOOK, axe_findings
from tests.system.played_console import playing

pytestmark = [pytest.mark.console, pytest.mark.timeout(400)]

SCENE = "phantom_sweep"
NEAR_MM = 5.0
LINK_LOST_S = 4
STROKES = """
[[script]]
act = "strokes"
x_m = [-0.022, 0.022]
y_m = [0.0265, 0.0315, 0.0365]
speed_mm_s = 40
"""
"""The index finger strokes over the lesion, again and again."""


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    folder = tmp_path_factory.mktemp("demo")
    tissue, _, _ = (resources.files("common") / "scenes" / f"{SCENE}.toml").read_text("utf-8").partition("# 0 s:")
    scene, network, out = folder / "lesion.toml", folder / "direct.toml", folder / "out"
    scene.write_text(tissue + STROKES, "utf-8")
    network.write_text("[[phase]]\nfrom_s = 0\ndelay_ms = 0\n", "utf-8")
    options = ("--scene", str(scene), "--network", str(network), "--fingers", "1", "--seed", "3")
    with running(out, *options) as demo:
        yield demo


def lesion_mm() -> tuple[float, float]:
    """The middle of the lesion."""
    thing = load_scene(SCENE).object_named("lesion")
    return thing.x_at(0.5) * 1e3, sum(thing.y_range_m) / 2.0 * 1e3


def test_the_lesion_is_found_the_link_is_cut_and_all_of_it_is_reported_and_played_again(
    browser: Any, demo: Demo, picture_of: Callable[[Any, str], None]
) -> None:
    x_mm, y_mm = lesion_mm()
    page = opened(browser, demo.address)
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    begin(page, "P-0417")
    engage(page)
    page.keyboard.press("r")
    page.wait_for_function("() => now.state.fingers[1].roughness_v > 0.03")
    picture_of(page, "demo engaged")
    page.keyboard.press("f")
    page.keyboard.press("1")
    aim(page, x_mm, y_mm)
    picture_of(page, "demo marking")
    page.keyboard.press("Enter")
    page.wait_for_selector("#marking", state="hidden")
    page.keyboard.press("n")
    page.keyboard.type("coarse grain")
    page.click("#noting [type=submit]")
    page.wait_for_selector("#noting", state="hidden")

    demo.command("network", f"partition {LINK_LOST_S}")
    page.wait_for_selector("#alarm-text:has-text('LINK LOST. Outputs are neutral. Wait for the link.')")
    page.wait_for_selector("body[data-shown=disconnected]")
    picture_of(page, "demo link cut")
    assert page.evaluate(LOOK) + axe_findings(page) == []
    # In the line stands an alarm that is not over, such as that of a slow machine.
    back = "() => now.state.alarms.some(({ text, waits }) => waits && text.startsWith('Link was lost'))"
    page.wait_for_function(back)
    picture_of(page, "demo link back")
    page.keyboard.press("k")
    page.wait_for_selector("#acknowledge-button", state="hidden")
    page.wait_for_selector(NEUTRAL)
    assert not state_of(page)["engage"]["wanted"]
    engage(page)

    (finding,) = state_of(page)["findings"]
    assert abs(finding["x_mm"] - x_mm) <= NEAR_MM
    assert abs(finding["y_mm"] - y_mm) <= NEAR_MM
    end(page)
    page.wait_for_selector("#report-link:visible", timeout=LONGEST_S * 1000)
    with page.context.expect_page() as opening:
        page.click("#report-link")
    report = opening.value
    report.wait_for_load_state()
    text = report.locator("body").text_content()  # the annex is collapsed
    for shown in ("P-0417", finding["text"], "coarse grain", "LINK LOST"):
        assert shown in text
    picture_of(report, "demo report")
    page.close()
    assert wrong == []

    with playing(demo.finish()) as address:
        played = opened(browser, address)
        played.wait_for_selector("body[data-shown=playback]")
        assert not played.is_visible("#stop")
        assert not played.is_visible("#act-button")
        assert played.locator("#ticks span.finding").count() == 1
        played.keyboard.press("End")
        played.wait_for_selector("#findings-list li:has-text('coarse grain')", state="attached")
        played.keyboard.press("Home")
        played.wait_for_function("() => now.state.findings.length === 0")
        played.keyboard.press("]")
        played.wait_for_function("() => now.state.session.playback.at_s > 0")
        played.keyboard.press("Space")
        played.wait_for_selector("#play-button:has-text('Pause')")
        at_s = state_of(played)["session"]["playback"]["at_s"]
        played.wait_for_function(f"() => now.state.session.playback.at_s > {at_s + 1.0}")
        picture_of(played, "demo played")
        assert played.evaluate(LOOK) + axe_findings(played) == []
        played.close()
