"""A scripted user who sees only the page explores the phantom, finds its three targets, and prints the report.

The user reads the map's colours, taps it for values, and takes the kinds that the console proposes. The test alone
knows the scene.
"""

import math
import re
from collections.abc import Callable, Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, label

from common.scenes.scene import load_scene
from operator_site.console.examination.reporting import LONGEST_S
from sim_sensors.operator_hand.hand import ScriptedHand
from teletaction.recordings.merge import merge_recordings
from teletaction.session.demo_files import DemoOptions
from tests.browser.live import end, opened
from tests.browser.running_testbed import RunningTestbed, running
from tests.browser.test_report import assert_printed, messages_of
from tests.commands import command

pytestmark = [pytest.mark.console, pytest.mark.timeout(2400), pytest.mark.real_time(stall_s=math.inf)]

SCENE, SEED = "phantom_sweep", 3
KINDS = {"temperature": "warm", "roughness": "rough", "stiffness": "stiff"}
"""Kind of a finding for the quantity of a target."""
NEAR_MM = 5.0
PATIENCE_MS = 120_000
SCRIPT = """
[[script]]
act = "strokes"
x_m = [-0.036, 0.036]
y_m = [-0.0075, -0.0025, 0.0025, 0.0075]
speed_mm_s = 40

[[script]]
act = "presses"
x_m = [-0.028, -0.021, -0.014, -0.007, 0.0, 0.007, 0.014, 0.021, 0.028, 0.035]
y_m = [-0.005, 0.005]
hold_s = 0.6

[[script]]
act = "presses"
fingers = ["index"]
x_m = [-0.025, 0.0, 0.025]
y_m = [-0.007, 0.000, 0.007, 0.014]
hold_s = 2.5
wait_s = 1.5
"""
"""Five fingers stroke and press, then one rests, as in the scene's own script, which takes eight minutes."""
HIGHER = """side_px => {
  const canvas = document.getElementById('map-surface'), { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height), rows = [];
  for (let top = 0; top + side_px <= height; top += side_px) {
    const row = [];
    for (let left = 0; left + side_px <= width; left += side_px) {
      let sum = 0;
      for (let y = top; y < top + side_px; y += 1) for (let x = left; x < left + side_px; x += 1) {
        const at = 4 * (y * width + x), red = data[at], blue = data[at + 2];
        sum += (red - blue) / (red + blue + 1);
      }
      row.push(sum / side_px ** 2);
    }
    rows.push(row);
  }
  return rows;
}"""
"""Mean redness of squares of the map: the colour of values above their surroundings, from -1 to 1."""
ANSWERED = "() => /^x .*: (?!No answer)/.test(document.getElementById('read-out').textContent)"
"""The page shows what is at a place; it repeats a request that had no answer."""
SQUARE_PX = 12
RED, STILL_MS = 0.1, 1000
"""Redness of a square that a comparison has coloured; time for which a finished map stays the same, ms.

Tiles come in groups, and a comparison is computed twice a second.
"""
STANDS_OUT, GAP_SQUARES = 0.4, 2
"""Share of the largest redness of the area that stands out, and half of the gaps that do not divide it."""
BESIDE_PX = 18
UNITS = {"t": "°C", "r": "of 10", "s": "N/m"}


class User:
    """Finds, marks, withdraws and compares, by what the page shows."""

    def __init__(self, page: Any) -> None:
        self.page = page

    def compare(self, key: str, comparison: str) -> None:
        """Show a quantity, by its key, in a comparison; wait until something red is there and the map stands still."""
        self.page.keyboard.press(key)
        self.page.select_option("#compare", comparison)
        self.page.focus("#map-surface")
        before, drawn = np.zeros(0), self._redness()
        while drawn.max() < RED or not np.array_equal(before, drawn):
            self.page.wait_for_timeout(STILL_MS)
            before, drawn = drawn, self._redness()

    def _redness(self) -> NDArray[np.float64]:
        """Mean redness of the squares of the map."""
        return np.array(self.page.evaluate(HIGHER, SQUARE_PX))

    def reddest(self) -> tuple[float, float]:
        """Middle of the area that stands out most on the map, px."""
        redness = self._redness()
        red = redness > STANDS_OUT * np.quantile(redness, 0.999)
        areas, count = label(binary_dilation(red, iterations=GAP_SQUARES))
        masks = [(areas == number) & red for number in range(1, count + 1)]
        largest = max(masks, key=lambda mask: float(redness[mask].sum()))
        rows, columns = np.nonzero(largest)
        weights = redness[largest]
        x, y = (SQUARE_PX * (float(np.average(places, weights=weights)) + 0.5) for places in (columns, rows))
        return x, y

    def tap(self, place: tuple[float, float]) -> str:
        """Tap the map; what the page says of that place."""
        self.page.hover("#map-surface")
        self.page.wait_for_function(ANSWERED)
        self.page.mouse.move(0, 0)
        self.page.wait_for_function("() => document.getElementById('read-out').textContent.startsWith('Point at')")
        self._click(place)
        self.page.wait_for_function(ANSWERED)
        return str(self.page.inner_text("#read-out"))

    def felt(self, key: str, place: tuple[float, float]) -> tuple[float, float]:
        """The place itself, or one just beside it, where a tap gives a contrast in the quantity of that key."""
        read = []
        for dx in (0, -BESIDE_PX, BESIDE_PX):
            for dy in (0, -BESIDE_PX, BESIDE_PX):
                beside = place[0] + dx, place[1] + dy
                read.append(self.tap(beside))
                if re.search(rf"± [\d.]+ {UNITS[key]}.* (K against|times the)", read[-1]):
                    return beside
        raise AssertionError(f"no contrast near {place}: {read}")

    def mark(self, place: tuple[float, float]) -> str:
        """Mark a place with the proposed kind; the kind."""
        self.page.click("#finding-button:enabled")
        self._click(place)
        self.page.wait_for_selector("#marking-contrast:has-text('Proposed')")
        kind = self.page.inner_text("#kinds [aria-pressed=true]").split()[0]
        self.page.keyboard.press("Enter")
        self.page.wait_for_selector("#marking", state="hidden")
        return str(kind)

    def _click(self, place: tuple[float, float]) -> None:
        box = self.page.locator("#map-surface").bounding_box()
        self.page.mouse.click(box["x"] + place[0], box["y"] + place[1])

    def withdraw(self, number: int, reason: str) -> None:
        """Withdraw a finding."""
        self.page.click(f"[data-edit='{number}']:enabled")
        self.page.click("#finding-withdraw")
        self.page.keyboard.type(reason)
        self.page.click("#withdrawing .first")
        self.page.wait_for_selector(f"[data-jump='{number}'] s")


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTestbed]:
    folder = tmp_path_factory.mktemp("user")
    tissue, _, _ = (resources.files("common") / "scenes" / f"{SCENE}.toml").read_text("utf-8").partition("# 0 s:")
    scene = folder / "short.toml"
    scene.write_text(tissue + SCRIPT, "utf-8")
    seconds = ScriptedHand(load_scene(str(scene)), seed=SEED).total_seconds()
    with running(DemoOptions(seconds, str(scene), SEED, console=True), folder / "out") as session:
        yield session


def test_a_user_of_the_page_alone_finds_marks_compares_and_prints(
    browser: Any, session: RunningTestbed, tmp_path: Path, picture_of: Callable[[Any, str], None]
) -> None:
    session.explored.wait()
    page = opened(browser, session.url, patience_ms=PATIENCE_MS)
    page.wait_for_selector("body[data-shown=paused]")

    user, found = User(page), list[str]()
    for key in "trs":
        user.compare(key, "around")
        picture_of(page, f"user {key}")
        place = user.felt(key, user.reddest())
        found.append(user.mark(place))
        if key == "t":
            warm = place
    assert found == ["warm", "rough", "stiff"]
    assert user.mark(place) == "stiff"
    user.withdraw(4, "marked twice")
    page.keyboard.press("x")
    user.compare("t", "mirror")
    here, there = (float(re.search(r"([\d.]+) ± [\d.]+ °C", part)[1]) for part in user.tap(warm).split("mirrored"))  # type: ignore[index]
    picture_of(page, "user left and right")

    end(page)
    page.wait_for_selector("#report-link:visible", timeout=LONGEST_S * 1000)
    with page.context.expect_page() as opening:
        page.click("#report-link")
    report = opening.value
    report.wait_for_load_state()
    assert "P-0417" in report.inner_text("body")
    picture_of(report, "user report")
    assert 2 <= len(re.findall(rb"/Type\s*/Page\b", report.pdf(format="A4"))) <= 3
    page.close()
    session.close()

    recording, pdf = tmp_path / "session.mcap", tmp_path / "report.pdf"
    merge_recordings([session.folder / f"{name}.mcap" for name in ("operator", "remote", "console")], recording)
    assert command("report", recording, "--out", pdf).code == 0
    assert_printed(recording, pdf, "3, and 1 withdrawn")
    standing = {one["id"]: one for one in messages_of(recording, "console/finding") if one["id"] != 4}
    by_kind = {one["kind"]: one for one in standing.values()}
    targets = {str(thing.target): thing for thing in load_scene(SCENE).objects if thing.target is not None}
    for quantity, thing in targets.items():
        marked = by_kind[KINDS[quantity]]
        true_mm = 1e3 * thing.x_at(0.5), 1e3 * sum(thing.y_range_m) / 2.0
        assert math.dist((1e3 * marked["x_m"], 1e3 * marked["y_m"]), true_mm) <= NEAR_MM, (quantity, marked)
    assert here - there == pytest.approx(2.0, abs=1.0)  # K, as in the scene
