"""The camera's picture on the page: decoded, with its age, named when it stands still, large or off."""

import re
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import FROZEN_S
from common.recording.camera_marks import are_marks
from operator_site.console.camera.camera_picture import Picture
from tests.browser.conftest import SIZES, Open, wait_for
from tests.browser.stage import Stage
from tests.browser.test_every_state import LOOK, axe_findings
from tests.vp8_stream import HEIGHT, WIDTH

pytestmark = [pytest.mark.console, pytest.mark.timeout(120)]

NAMED_MS = 500.0
"""Longest time from the last picture until the page names it, ms."""
LIVE_TEXT = "#camera-said:has-text('Picture 0.')"
PIXELS = """() => {
  const canvas = document.getElementById('camera-picture'), pen = canvas.getContext('2d');
  const row = pen.getImageData(0, 48, canvas.width, 1).data, bright = [];
  for (let x = 0; x < canvas.width; x += 1) if (row[4 * x] > 150) bright.push(x);
  return [canvas.width, canvas.height, bright.length, bright[0] ?? -1];
}"""
NAMED = """() => new Promise(resolve => {
  const said = document.getElementById('camera-said'), canvas = document.getElementById('camera-picture');
  let drawn = performance.now();
  const draw = CanvasRenderingContext2D.prototype.drawImage;
  CanvasRenderingContext2D.prototype.drawImage = function (...given) {
    if (this.canvas === canvas) drawn = performance.now();
    return draw.apply(this, given);
  };
  new MutationObserver((_, watch) => {
    if (!said.textContent.includes('frozen')) return;
    watch.disconnect();
    const marked = document.getElementById('camera').classList.contains('frozen');
    resolve([performance.now() - drawn, marked, said.textContent]);
  }).observe(said, { characterData: true, childList: true, subtree: true });
})"""

FROZEN_AT = """() => new Promise(resolve => {
  const camera = document.getElementById('camera');
  new MutationObserver((_, watch) => {
    if (!camera.classList.contains('frozen')) return;
    watch.disconnect();
    resolve(performance.now());
  }).observe(camera, { attributes: true });
})"""

MOVED = f"async before => {{ while (({PIXELS})()[3] === before) await new Promise(requestAnimationFrame); }}"


def test_the_picture_is_shown_with_its_age(stage: Stage, open_page: Open) -> None:
    page = open_page("watching")
    page.wait_for_selector(LIVE_TEXT)
    age_s = float(re.findall(r"Picture (\d\.\d\d) s", page.inner_text("#camera-said"))[0])
    assert age_s < FROZEN_S
    width, height, bright, first = page.evaluate(PIXELS)
    assert (width, height) == (WIDTH, HEIGHT)
    assert 28 <= bright <= 36
    page.evaluate(MOVED, first)
    assert "Reduced for touch" in page.inner_text("#camera-said")
    stage.scenario.state["camera"]["reduced"] = False
    page.wait_for_selector("#camera-said:not(:has-text('Reduced'))")


@pytest.mark.real_time(stall_s=0.05)
def test_a_frozen_picture_is_named_and_marked_within_half_a_second(stage: Stage, open_page: Open) -> None:
    page = open_page("watching")
    page.wait_for_selector(LIVE_TEXT)
    page.evaluate(f"() => {{ window.named = ({NAMED})(); }}")
    page.wait_for_timeout(500)
    stage.films = False
    named_ms, marked, text = page.evaluate("() => window.named")
    assert marked
    assert re.fullmatch(r"Picture frozen for 0\.\d s", text)
    assert named_ms <= NAMED_MS
    print(f"frozen picture named {named_ms:.0f} ms after the last drawn one")
    stage.films = True
    page.wait_for_selector(LIVE_TEXT)
    assert not page.evaluate("document.getElementById('camera').classList.contains('frozen')")


def test_it_is_named_while_the_console_is_silent_and_followed_when_it_returns(stage: Stage, open_page: Open) -> None:
    page = open_page("watching")
    page.wait_for_selector(LIVE_TEXT)
    stage.scenario.sends = stage.films = False
    page.wait_for_selector("#camera.frozen #camera-said:has-text('frozen for')")
    stage.scenario.sends = stage.films = True
    page.wait_for_selector(LIVE_TEXT)


def test_it_is_small_large_or_off_and_hidden_without_a_camera(stage: Stage, open_page: Open) -> None:
    page = open_page("watching")
    page.wait_for_selector(LIVE_TEXT)
    wide = [page.eval_on_selector("#camera", "e => e.clientWidth")]
    page.keyboard.press("w")
    page.wait_for_selector("#map-view[data-camera=large]")
    wide.append(page.eval_on_selector("#camera", "e => e.clientWidth"))
    assert wide[1] > 2 * wide[0]
    page.click("#camera")
    page.wait_for_selector("#camera-picture", state="hidden")
    assert "Picture 0." in page.inner_text("#camera-said")
    page.keyboard.press("w")
    page.wait_for_selector("#camera-picture", state="visible")
    stage.show("engaged")
    page.wait_for_selector("#camera", state="hidden")


@pytest.mark.parametrize("size", SIZES)
def test_the_large_picture_and_its_tools_fit_and_are_accessible(open_page: Open, size: str) -> None:
    page = open_page("watching", SIZES[size])
    page.wait_for_selector(LIVE_TEXT)
    page.keyboard.press("w")
    page.wait_for_selector("#map-view[data-camera=large]")
    assert page.evaluate(LOOK) + axe_findings(page) == []
    page.keyboard.press("w")
    page.click("#photo-button")
    page.click("#photo-camera")
    page.wait_for_selector("#photo-adjust[aria-pressed=true]")
    assert page.evaluate(LOOK) + axe_findings(page) == []


def test_what_is_missing_is_named(stage: Stage, open_page: Open) -> None:
    page = open_page("unseen")
    page.wait_for_selector("#camera.frozen #camera-said:has-text('No camera')")
    for seen, text in (("refused", "Camera refuses the key"), ("silent", "No picture yet")):
        stage.scenario.state["camera"]["seen"] = seen
        page.wait_for_selector(f"#camera-said:has-text('{text}')")


NO_DECODER = "delete window.VideoDecoder;"


@pytest.mark.parametrize(
    ("script", "why"),
    [
        (NO_DECODER, "this browser decodes no video"),
        (NO_DECODER + "Object.defineProperty(window, 'isSecureContext', { value: false });", "this page has no HTTPS"),
        ("VideoDecoder.prototype.configure = () => { throw new DOMException('', 'NotSupportedError'); };", "no video"),
    ],
)
def test_a_browser_without_a_decoder_shows_still_pictures_and_says_why(
    stage: Stage, open_page: Open, picture_of: Callable[[Any, str], None], script: str, why: str
) -> None:
    page = open_page("watching", script=script)
    page.wait_for_selector(LIVE_TEXT, timeout=60_000)  # the process that decodes starts with the first picture
    text = page.inner_text("#camera-said")
    assert "Still pictures" in text
    assert why in text
    width, height, bright, first = page.evaluate(PIXELS)
    assert (width, height) == (WIDTH, HEIGHT)
    assert 28 <= bright <= 36
    page.evaluate(MOVED, first)
    picture_of(page, f"still {why}")
    stage.scenario.state["camera"]["seen"] = "late"
    page.wait_for_selector("#camera.frozen #camera-said:has-text('late by')")
    stage.scenario.state["camera"]["seen"] = "live"
    page.wait_for_selector("#camera:not(.frozen)")
    page.evaluate(f"() => {{ window.frozen = ({FROZEN_AT})(); }}")
    stage.films = False
    last_ms = page.evaluate("performance.now()")
    named_ms = page.evaluate("() => window.frozen") - last_ms
    print(f"frozen camera named {named_ms:.0f} ms after its last picture, beside still ones")
    page.wait_for_selector("#camera.frozen #camera-said:has-text('frozen for')")
    stage.films = True
    page.wait_for_selector(LIVE_TEXT)
    page.keyboard.press("w")
    assert page.evaluate(LOOK) + axe_findings(page) == []


def test_still_pictures_come_at_most_twice_a_second(open_page: Open) -> None:
    page = open_page("watching", script=NO_DECODER)
    page.wait_for_selector(LIVE_TEXT, timeout=60_000)
    drawn = page.evaluate(
        """() => new Promise(resolve => {
          const canvas = document.getElementById('camera-picture'), at = [];
          const draw = CanvasRenderingContext2D.prototype.drawImage;
          CanvasRenderingContext2D.prototype.drawImage = function (...given) {
            if (this.canvas === canvas) at.push(performance.now());
            return draw.apply(this, given);
          };
          setTimeout(() => resolve(at.length), 4000);
        })"""
    )
    assert 1 <= drawn <= 9


def test_a_console_that_makes_no_still_pictures_says_what_is_missing(stage: Stage, open_page: Open) -> None:
    stage.show("watching").state["camera"]["stills"] = False
    page = open_page(script=NO_DECODER)
    page.wait_for_selector("#camera.frozen #camera-said:has-text('HTTPS or localhost')")
    assert page.is_hidden("#camera-picture")


def test_damaged_pictures_are_skipped_and_the_next_key_picture_is_shown(stage: Stage, open_page: Open) -> None:
    page = open_page("watching")
    page.wait_for_selector(LIVE_TEXT)

    async def damage() -> None:
        for content in (b"\xff" * 50, b""):
            stage.camera.restart([Picture(10**6, 0.0, 0.0, True, WIDTH, HEIGHT, content)])

    drawn = page.evaluate(PIXELS)[3]
    stage._on_loop(damage())
    page.evaluate(MOVED, drawn)
    page.wait_for_selector(LIVE_TEXT)


@given(
    st.tuples(
        st.integers(0, 2**32 - 1),
        st.floats(0.0, 1e9),
        st.floats(0.0, 10.0, width=32),
        st.booleans(),
        st.integers(16, 4096),
        st.integers(16, 4096),
        st.binary(min_size=1, max_size=20),
    )
)
def made(values: Any) -> None:
    """Keep an example of a picture."""
    MADE.append(Picture(*values))


MADE: list[Picture] = []


def test_the_page_reads_what_the_console_packs(stage: Stage, open_page: Open) -> None:
    page = open_page("connected")
    made()
    read = page.evaluate(
        """async packed => {
          const { decodePicture } = await import('/page/camera.js');
          return packed.map(bytes => {
            const p = decodePicture(new Uint8Array(bytes).buffer);
            return [p.sequence, p.captured_s, p.uncertainty_s, p.isKey, p.width, p.height, [...p.content]];
          });
        }""",
        [list(picture.encode()) for picture in MADE],
    )
    assert [tuple(values[:6]) for values in read] == [
        (one.sequence, one.captured_s, one.uncertainty_s, one.is_key, one.width, one.height) for one in MADE
    ]
    assert [bytes(values[6]) for values in read] == [one.content for one in MADE]
    whole = MADE[0].encode()
    broken = [whole[:24], b"", whole[:10], b"\0" + whole[1:], whole[:2] + b"\2" + whole[3:]]
    refused = page.evaluate(
        """async packed => {
          const { decodePicture } = await import('/page/camera.js');
          return packed.map(bytes => {
            try { decodePicture(new Uint8Array(bytes).buffer); } catch { return true; }
            return false;
          });
        }""",
        [list(bytes_) for bytes_ in broken],
    )
    assert refused == [True] * len(broken)


FITTED = """async marks => {
  const { fitMarks } = await import('/page/camera_marks.js');
  return fitMarks(marks);
}"""


@pytest.mark.parametrize("off_mm", [0.0, 4.0])
def test_four_marks_register_the_picture_and_say_the_error(open_page: Open, off_mm: float) -> None:
    page = open_page("connected")
    matrix = [180.0, 20.0, 15.0, -90.0, -70.0, 40.0]
    a, d, b, e, c, f = matrix
    places = [(0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8)]
    marks = [
        {"u": u, "v": v, "x": a * u + b * v + c + (off_mm if at % 2 else -off_mm), "y": d * u + e * v + f}
        for at, (u, v) in enumerate(places)
    ]
    fitted = page.evaluate(FITTED, marks)
    assert fitted["matrix"] == pytest.approx(matrix, abs=1e-6)
    assert fitted["error_mm"] == pytest.approx(2.0 * off_mm, abs=1e-6)  # each mark is off by as much
    on_a_line = [mark | {"v": mark["u"]} for mark in marks]
    assert page.evaluate(FITTED, on_a_line) is None
    assert page.evaluate(FITTED, marks[:3]) is None


def with_the_map_over_the_camera(open_page: Open) -> Any:
    """A page whose map is about to be laid over the camera's picture."""
    page = open_page("watching")
    page.wait_for_selector(LIVE_TEXT)
    page.click("#photo-button")
    page.click("#photo-camera")
    return page


def test_the_map_is_laid_over_the_camera_by_touched_marks(stage: Stage, open_page: Open) -> None:
    page = with_the_map_over_the_camera(open_page)
    page.wait_for_selector("#photo-adjust[aria-pressed=true]")
    page.click("#photo-marks")
    page.wait_for_selector("#map-view[data-camera=large]")
    box = page.locator("#camera-picture").bounding_box()
    for number, (across, down) in enumerate(((0.3, 0.4), (0.7, 0.4), (0.7, 0.6), (0.3, 0.6)), 1):
        page.wait_for_selector(f"#photo-said:has-text('Mark {number} of 4')")
        page.mouse.click(box["x"] + across * box["width"], box["y"] + down * box["height"])
    page.wait_for_selector("#photo-said:has-text('Registered: error')")
    details = wait_for(stage, "camera_marks")[0]["details"]
    assert are_marks(details), "recorded, so that a report can cover the picture elsewhere"
    assert [details[f"u{number}"] for number in range(1, 5)] == pytest.approx([0.3, 0.7, 0.7, 0.3], abs=0.02)
    page.wait_for_selector("#map-view[data-camera=small]")
    stage.scenario.touching = set()
    page.click("#photo-marks")
    page.wait_for_timeout(300)  # several pictures without a touch
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.wait_for_selector("#photo-said:has-text('No finger touches')")
    page.click("#photo-remove")


@pytest.mark.parametrize("way", ["#photo-remove", "#photo-adjust", "#photo-button"])
def test_a_registration_that_was_begun_can_be_given_up(open_page: Open, way: str) -> None:
    page = with_the_map_over_the_camera(open_page)
    page.click("#photo-marks")
    page.wait_for_selector("#map-view[data-camera=large]")
    page.click(way)
    page.wait_for_selector("#map-view[data-camera=small]")
    assert page.text_content("#photo-said") == ""
    page.click("#camera")
    page.wait_for_selector("#map-view[data-camera=large]")
    page.click("#camera")
    page.wait_for_selector("#map-view[data-camera=off]")
