"""The camera's pictures of a recording, in a real browser: the one of the shown moment, after a jump too."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgpack
import pytest

from common.recording.recorder import Recorder
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.examination.journal import SCHEMAS as KEPT
from operator_site.site_recording import SCHEMAS
from tests.browser.conftest import LIVE
from tests.browser.test_camera import LIVE_TEXT, PIXELS
from tests.system.played_console import playing
from tests.unit.operator_site.console.fed import S, figures, rendered, touch
from tests.vp8_stream import HEIGHT, HZ, WIDTH, pictures

pytestmark = [pytest.mark.console, pytest.mark.timeout(120), pytest.mark.real_time(stall_s=math.inf)]

START_NS, SECONDS, LATE_NS = 100 * S, 10, 50_000_000
"""A picture is recorded 50 ms after it was captured."""
STEP_PX = 4
"""Motion of the bright square from one picture to the next, pixels."""
SETTLED = f"""async wanted => {{
  const first = () => ({PIXELS})()[3];
  for (let frame = 0; frame < 300 && Math.abs(first() - wanted) > 2; frame += 1) {{
    await new Promise(requestAnimationFrame);
  }}
  return first();
}}"""


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    path: Path = tmp_path_factory.mktemp("played") / "session.mcap"
    coded = pictures()
    with Recorder(path, SCHEMAS | KEPT, {}) as recorder:
        for tick in range(SECONDS * 100):
            at_ns = START_NS + tick * S // 100
            recorder.write("operator/touch", at_ns, touch(tick, at_ns - 20_000_000))
            recorder.write("operator/rendered", at_ns, rendered())
            if tick % 100 == 0:
                recorder.write("operator/figures", at_ns, figures())
        for number in range(SECONDS * HZ):
            is_key, content = coded[number % len(coded)]
            at_ns = START_NS + number * S // HZ
            made = Picture(number, (at_ns - LATE_NS) * 1e-9, 0.001, is_key, WIDTH, HEIGHT, content)
            recorder.write("console/camera", at_ns, msgpack.packb(made.record()))
    with playing(path) as served:
        yield served


def left_px(at_s: float) -> int:
    """Left edge of the square in the picture of a moment, pixels."""
    return STEP_PX * (int(at_s * HZ + 1e-6) % len(pictures()))


def test_the_picture_is_that_of_the_moment(browser: Any, address: str) -> None:
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.goto(address)
    page.wait_for_selector(LIVE)
    page.wait_for_selector("#camera:not([hidden])")
    for at_s in (4.5, 1.3, 8.9, 8.3):
        page.evaluate(
            """at => {
              const slider = document.getElementById('slider');
              slider.value = String(at);
              slider.dispatchEvent(new Event('input'));
            }""",
            at_s,
        )
        assert abs(page.evaluate(SETTLED, left_px(at_s)) - left_px(at_s)) <= 2, at_s
        page.wait_for_selector(LIVE_TEXT)
    assert "frozen" not in (page.get_attribute("#camera", "class") or "")
    page.keyboard.press(" ")
    page.evaluate(SETTLED, left_px(9.5))
    page.wait_for_selector(LIVE_TEXT)
    page.close()
