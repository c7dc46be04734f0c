"""A patient who is seen and heard, feels pain and stops, in one examination on a running demo, and its report."""

import math
import re
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from common.fingers import FINGERS
from common.limits import SWITCH_HOLD_S
from common.recording.reader import RecordingReader
from common.scenes.scene import load_scene
from operator_site.console.examination.reporting import LONGEST_S
from sim_sensors.physics.camera_view import CameraView
from tests.browser.live import begin, end, engage, opened, state_of
from tests.browser.running_demo import Demo, running
from tests.browser.test_camera import LIVE_TEXT
from tests.browser.test_voice import SAID
from tests.system.played_console import playing

pytest.importorskip("av", reason="the extra `camera` is not installed")
pytestmark = [pytest.mark.console, pytest.mark.timeout(500)]

SCENE = "tender_place"
INDEX = FINGERS.index("index")
AGREED = ("touch", "pain", "picture", "voice")
LONG_MS = 90_000.0
"""Patience with what the script of the scene has to come to, ms."""
APART_MM = 8.0
"""Least distance of two marks."""
REGISTERED_MM = 3.0
TOUCHES = f"() => now.picture.contact({INDEX})"
PLACE_M = f"() => [now.picture.of({INDEX}, 'x_m'), now.picture.of({INDEX}, 'y_m')]"


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    options = ("--scene", SCENE, "--fingers", "1", "--camera", "--voice", "--consent", ",".join(AGREED))
    with running(tmp_path_factory.mktemp("patient") / "out", *options) as demo:
        yield demo


def register(page: Any) -> float:
    """Lay the camera's picture under the map by four places that the index finger presses; the stated error, mm."""
    page.click("#photo-button")
    page.click("#photo-camera")
    page.click("#photo-marks")
    box = page.locator("#camera-picture").bounding_box()
    wide, high = page.eval_on_selector("#camera-picture", "canvas => [canvas.width, canvas.height]")
    view = CameraView(load_scene(SCENE), ("index",), wide, high)
    marked: list[tuple[float, float]] = []
    while len(marked) < 4:
        page.wait_for_function(TOUCHES)
        x_m, y_m = page.evaluate(PLACE_M)
        in_row = sum(abs(y_m - other[1]) < 1e-3 * APART_MM / 2.0 for other in marked)
        if in_row < 2 and all(math.dist((x_m, y_m), other) > 1e-3 * APART_MM for other in marked):
            column, row = view.place(x_m, y_m)
            page.mouse.click(box["x"] + column / wide * box["width"], box["y"] + row / high * box["height"])
            page.wait_for_timeout(50)
            said = page.inner_text("#photo-said")
            if f"Mark {len(marked) + 2} of 4" in said or "Registered" in said:
                marked.append((x_m, y_m))
        page.wait_for_function(f"() => !({TOUCHES})()")
    found = re.search(r"Registered: error ([\d.]+) mm", page.inner_text("#photo-said"))
    assert found
    return float(found[1])


def test_a_patient_is_seen_heard_and_felt_and_stops_and_the_report_shows_it(
    browser: Any, demo: Demo, picture_of: Callable[[Any, str], None]
) -> None:
    page = opened(browser, demo.address)
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    begin(page, "P-0417")
    page.wait_for_selector(LIVE_TEXT)
    page.wait_for_selector(SAID.format("Voice"))
    engage(page)

    error_mm = register(page)
    print(f"registered with an error of {error_mm} mm")
    assert error_mm < REGISTERED_MM
    picture_of(page, "patient registered")

    page.wait_for_selector("#patient:has-text('Most tender near')", timeout=LONG_MS)
    said = page.inner_text("#patient").replace("−", "-")
    found = re.search(r"Most tender near x (-?\d+) y (-?\d+) mm, ± (\d+) mm", said)
    assert found, said
    x_mm, y_mm, sd_mm = map(float, found.groups())
    place = load_scene(SCENE).tender[0]
    assert math.dist((x_mm, y_mm), (1e3 * place.x_m, 1e3 * place.y_m)) < 2.5 * sd_mm
    page.keyboard.press("f")
    page.keyboard.press("7")
    page.keyboard.press("Enter")
    page.wait_for_selector("#marking", state="hidden")
    picture_of(page, "patient tender")

    # A clutch that closes in a press keeps the finger in contact, and a scale is refused there.
    page.wait_for_function(f"() => !({TOUCHES})()")
    page.keyboard.down("g")
    page.wait_for_selector("#coupling:has-text('clutch open')")
    page.keyboard.up("g")
    page.wait_for_selector("#coupling:not(:has-text('clutch open'))", state="attached")
    for scale in ("2", "1"):
        while page.evaluate("String(now.state.coupling.scale)") != scale:
            page.wait_for_function(f"() => !({TOUCHES})()")
            page.select_option("#scale", scale)
            page.wait_for_timeout(300)

    demo.command("sim-remote", "press")
    page.wait_for_selector("#alarm-text:has-text('Patient stopped. Remote side asks patient, then clears.')")
    page.wait_for_selector("body:not([data-shown=engaged])")
    picture_of(page, "patient stopped")
    demo.command("sim-remote", "mend")
    time.sleep(SWITCH_HOLD_S)
    demo.say("session", "clear", "--config", str(demo.out / "config" / "remote.toml"))
    engage(page)
    page.wait_for_selector(LIVE_TEXT)
    (finding,) = state_of(page)["findings"]
    assert finding["kind"] == "tender"

    end(page)
    page.wait_for_selector("#report-link:visible", timeout=LONGEST_S * 1000)
    with page.context.expect_page() as opening:
        page.click("#report-link")
    report = opening.value
    report.wait_for_load_state()
    text = report.locator("body").text_content()
    for shown in ("P-0417", finding["text"], "patient stopped", "most tender place"):
        assert shown in text
    still = report.locator("img[alt='Camera at finding 1']").first
    assert still.evaluate("image => image.complete && image.naturalWidth > 100")
    picture_of(report, "patient report")
    page.close()
    assert wrong == []

    recording = demo.finish()
    kept = ["console/camera", "console/voice"]
    with recording.open("rb") as file:
        assert {channel.topic for _, channel, _ in RecordingReader(recording, file).messages(kept)} == {*kept}
    with playing(recording) as address:
        played = opened(browser, address)
        played.wait_for_selector("body[data-shown=playback]")
        played.keyboard.press("End")
        played.wait_for_selector("#camera-picture", state="visible")
        played.wait_for_selector(LIVE_TEXT)
        picture_of(played, "patient played")
        played.close()
