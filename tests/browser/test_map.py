"""The tactile map: half of the screen, fitted, compared, beside another quantity or over a picture; by any input."""

import math
import struct
import zlib
from typing import Any

import pytest

from tests.browser.conftest import SIZES, Open, wait_for
from tests.browser.stage import Stage
from tests.browser.synthetic import SCENARIOS, Scenario
from tests.browser.test_every_state import LOOK
from tests.waiting import wait_until

pytestmark = [pytest.mark.console, pytest.mark.real_time(stall_s=math.inf)]

VIEW = """async () => {
  const { viewOf } = await import('/page/map_view.js'), at = viewOf(document.getElementById('map-surface'));
  const edges = { left: at.x_mm(0), right: at.x_mm(at.width), near: at.y_mm(at.height), far: at.y_mm(0) };
  return { scale: at.scale, x: at.centre.x, y: at.centre.y, ...edges };
}"""
DIFFERENCE = """async ([quantity, comparison, column, row, axis]) => {
  const { differences } = await import('/page/map_compare.js');
  return differences(quantity, comparison, [-10, 60], axis)[row * 256 + column];
}"""
KNOWN = """async ([column, row]) => {
  const { kept } = await import('/page/map_tiles.js');
  return kept.temperature.values[row * 256 + column] !== 65535;
}"""
FOLLOW = """() => {
  window.shown = [];
  const readOut = document.getElementById('read-out'), all = { childList: true, characterData: true, subtree: true };
  new MutationObserver(() => shown.push(readOut.textContent)).observe(readOut, all);
}"""
"""Keeps every text of the read-out."""
PINCH = """([from, to]) => {
  const canvas = document.getElementById('map-surface'), box = canvas.getBoundingClientRect();
  canvas.setPointerCapture = () => {};
  const send = (kind, id, x) => canvas.dispatchEvent(new PointerEvent(kind, {
    pointerId: id, pointerType: 'touch', bubbles: true,
    clientX: box.left + box.width / 2 + x, clientY: box.top + box.height / 2 }));
  send('pointerdown', 1, -from); send('pointerdown', 2, from);
  for (let step = 1; step <= 4; step += 1)
    for (const [id, side] of [[1, -1], [2, 1]]) send('pointermove', id, side * (from + (to - from) * step / 4));
  send('pointerup', 1, -to); send('pointerup', 2, to);
}"""
COLOURS = """() => {
  const canvas = document.getElementById('map-surface'), middle = [canvas.width / 2 - 20, canvas.height / 2 - 8];
  return [...new Set(new Uint32Array(canvas.getContext('2d').getImageData(...middle, 16, 16).data.buffer))];
}"""
"""Colours of felt places in the middle of the map."""
LEGEND = """async () => {
  const { inkOf } = await import('/page/map_tiles.js'), places = Array.from({ length: 256 }, (_, at) => at / 255);
  const inks = places.map(place => inkOf('temperature', place));
  return inks.map(([red, green, blue]) => ((255 * 256 + blue) * 256 + green) * 256 + red);
}"""
WHITE = 0xFFFFFFFF
WORDS_AROUND_NEXT = """async ([dx, dy]) => {
  const { drawOver, drawStill } = await import('/page/map_over.js'), { now } = await import('/page/now.js');
  const canvas = document.getElementById('map-over'), words = [], { width, height } = canvas.getBoundingClientRect();
  const [x, y] = ['x_m', 'y_m'].map(name => now.picture.of(1, name) * 1000);
  const toX = x_mm => width / 2 + 4 * (x_mm - x), toY = y_mm => height / 2 - 4 * (y_mm - y);
  const pen = canvas.getContext('2d'), before = now.state, next_mm = [x + dx / 4, y - dy / 4];
  now.state = { ...before, findings: [], patient: null, map: { ...before.map, sides: null, lumps: [], next_mm } };
  pen.fillText = (text, left, top) => {
    const wide = pen.measureText(text).width / 2, middle = left + { left: wide, right: -wide }[pen.textAlign] || left;
    words.push({ text, left: middle - wide, right: middle + wide, top: top - 12, bottom: top });
  };
  for (const draw of [drawStill, drawOver]) draw(canvas, { width, height, scale: 4, toX, toY }, null, null, null);
  delete pen.fillText;
  now.state = before;
  const [left, top] = [width / 2 + dx, height / 2 + dy];
  const mark = { text: 'mark', left: left - 8, right: left + 8, top: top - 8, bottom: top + 8 };
  return [...words.filter(({ text }) => ['next', 'D2'].includes(text)), mark];
}"""
"""Words that are drawn while the next place to press is at (dx, dy) px from the index, and that place's mark."""
NAMES_OF_LUMPS = """async (probabilities) => {
  const { drawOver } = await import('/page/map_over.js'), { now } = await import('/page/now.js');
  const canvas = document.getElementById('map-over'), words = [], { width, height } = canvas.getBoundingClientRect();
  const pen = canvas.getContext('2d'), before = now.state, outline_mm = [[0, 0], [9, 0], [9, 9]];
  const lumps = probabilities.map(probability => ({ outline_mm, probability, at_edge: false, x_mm: 3 }));
  now.state = { ...before, findings: [], patient: null, map: { ...before.map, lumps, next_mm: null } };
  pen.fillText = text => words.push(text);
  drawOver(canvas, { width, height, scale: 4, toX: x => x, toY: y => y }, null, null, null);
  delete pen.fillText;
  now.state = before;
  return words.filter(text => text.startsWith('lump'));
}"""
"""Names of lumps with these probabilities."""
TOUCH = {"has_touch": True}


def view(page: Any) -> dict[str, float]:
    return dict(page.evaluate(VIEW))


def overlap(one: dict[str, float], other: dict[str, float]) -> bool:
    wide = min(one["right"], other["right"]) - max(one["left"], other["left"])
    high = min(one["bottom"], other["bottom"]) - max(one["top"], other["top"])
    return wide > 0.0 and high > 0.0


def wait_for_cell(page: Any, column: int, row: int) -> None:
    wait_until(lambda: page.evaluate(KNOWN, [column, row]), "the cell is not there", 10.0)


def felt(felt_mm: list[float] | None, **cells: int) -> Scenario:
    scenario = SCENARIOS["engaged"]()
    scenario.state["map"].update(
        felt_mm=felt_mm,
        felt_cells=dict.fromkeys(("temperature", "roughness", "stiffness", "material"), 0) | cells,
    )
    return scenario


def png(width: int, height: int) -> bytes:
    """A white picture."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = (b"\x00" + b"\xff" * 3 * width) * height
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def test_the_probability_of_a_lump_is_written_as_in_the_report(open_page: Open) -> None:
    page = open_page("engaged")
    assert page.evaluate(NAMES_OF_LUMPS, [0.6, 0.994, 0.999]) == ["lump 60 %", "lump 99 %", "lump > 99 %"]


@pytest.mark.parametrize("size", [(1440, 900, 1), (1024, 768, 1), (800, 1280, 1)])
def test_it_is_half_of_the_screen_and_filled_by_what_was_felt(open_page: Open, size: tuple[int, int, int]) -> None:
    page = open_page("engaged", size)
    box = page.locator("#map").bounding_box()
    assert box["width"] * box["height"] >= 0.5 * size[0] * size[1]
    page.wait_for_selector("#fit-button[disabled]")
    at = view(page)
    assert (at["left"] <= -70.0, at["right"] >= 95.0, at["near"] <= -48.0, at["far"] >= 48.0) == (True,) * 4
    filled = max(165.0 / (at["right"] - at["left"]), 96.0 / (at["far"] - at["near"]))
    assert filled >= 0.8


def test_it_grows_with_what_is_felt_but_not_with_every_touch(stage: Stage, open_page: Open) -> None:
    page = open_page()
    stage.show(felt([0.0, 0.0, 40.0, 40.0]))
    page.wait_for_function(f"({VIEW})().then(at => Math.abs(at.x - 20) < 1)")
    before = view(page)
    stage.show(felt([0.0, 0.0, 42.0, 40.0]))
    page.wait_for_function("import('/page/now.js').then(({ now }) => now.state.map.felt_mm[2] === 42)")
    assert view(page) == before, "a touch inside the margin moves nothing"
    stage.show(felt([0.0, 0.0, 90.0, 40.0]))
    page.wait_for_function(f"({VIEW})().then(at => at.x > 40)")
    assert view(page)["right"] >= 90.0


def test_it_opens_on_the_fullest_quantity_until_another_is_chosen(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    stage.show(felt([0.0, 0.0, 40.0, 40.0], temperature=30, stiffness=900))
    page.wait_for_selector("[data-quantity=stiffness][aria-pressed=true]")
    page.click("[data-quantity=roughness]")
    stage.show(felt([0.0, 0.0, 40.0, 40.0], temperature=9000, stiffness=900))
    page.wait_for_function("import('/page/now.js').then(({ now }) => now.state.map.felt_cells.temperature === 9000)")
    assert page.get_attribute("[data-quantity=roughness]", "aria-pressed") == "true"


@pytest.mark.parametrize("by", ["mouse", "touch", "keys"])
def test_it_is_moved_zoomed_and_fitted_again(open_page: Open, by: str) -> None:
    page = open_page("engaged", **(TOUCH if by == "touch" else {}))
    page.wait_for_selector("#fit-button[disabled]")
    first = view(page)
    box = page.locator("#map-surface").bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    if by == "mouse":
        page.mouse.move(*middle)
        page.mouse.wheel(0, -100)
    elif by == "touch":
        page.evaluate(PINCH, [50, 100])
    else:
        page.keyboard.press("+")
    page.wait_for_function(f"({VIEW})().then(at => at.scale > {first['scale']} * 1.1)")
    if by == "touch":
        assert view(page)["scale"] == pytest.approx(2.0 * first["scale"], rel=0.05)
    if by == "mouse":
        zoomed = view(page)
        page.mouse.down()
        page.mouse.move(middle[0] + 100, middle[1], steps=4)
        page.mouse.up()
        assert view(page)["x"] == pytest.approx(zoomed["x"] - 100 / zoomed["scale"], abs=1.0)
    {
        "mouse": lambda: page.click("#fit-button"),
        "touch": lambda: page.tap("#fit-button"),
        "keys": lambda: page.keyboard.press("x"),
    }[by]()
    page.wait_for_function(f"({VIEW})().then(at => at.scale === {first['scale']})")


def test_a_tap_keeps_the_value_of_a_place(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged", **TOUCH)
    page.tap("#map-surface", position={"x": 200, "y": 200})
    page.wait_for_selector("#read-out:has-text('36.4 ± 0.2 °C')")
    asked = wait_for(stage, "place")[-1]["details"]
    page.wait_for_timeout(600)  # two rounds of the read-out
    assert "36.4 ± 0.2 °C" in page.inner_text("#read-out")
    at = view(page)
    assert asked["x_mm"] == pytest.approx(at["left"] + 200 / at["scale"], abs=0.5)


def test_a_late_value_does_not_replace_what_was_shown_since(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    stage.answers["place"] = lambda _: {"ok": None}
    page.hover("#map-surface")
    ask = wait_for(stage, "place")[-1]
    page.mouse.move(0, 0)
    page.wait_for_selector("#read-out:has-text('Point at')")
    page.evaluate(FOLLOW)
    stage.answer_late(ask, {"text": "36.4 ± 0.2 °C"})
    page.wait_for_timeout(600)  # two rounds of the read-out
    assert page.evaluate("shown") == []


def test_two_quantities_stand_side_by_side_at_the_same_places(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("s")
    page.keyboard.press("v")
    page.wait_for_selector("#map-surface-2", state="visible")
    assert stage.shown[-1] == {"kind": "show", "quantity": "stiffness", "second": "temperature"}
    names = page.eval_on_selector_all(".pane canvas[role=img]", "all => all.map(one => one.getAttribute('aria-label'))")
    assert [name.split(";")[0] for name in names] == ["Map of stiffness", "Map of temperature"]
    assert page.eval_on_selector_all("#legend .name", "all => all.map(one => one.textContent)") == [
        "Stiffness",
        "Temperature",
    ]
    wide = [page.locator(f"#{name}").bounding_box()["width"] for name in ("map-surface", "map-surface-2")]
    assert wide[0] == pytest.approx(wide[1], abs=1.0)
    page.click("#both-button")
    page.wait_for_selector("#map-surface-2", state="hidden")


@pytest.mark.parametrize("size", SIZES)
def test_two_quantities_have_room_for_their_scales(open_page: Open, size: str) -> None:
    page = open_page("engaged", SIZES[size])
    page.keyboard.press("v")
    for key in "trs":
        page.keyboard.press(key)
        page.wait_for_selector(f"#quantities [aria-pressed=true]:has(kbd:text-is('{key.upper()}'))")
        page.wait_for_timeout(300)  # the map is painted ten times a second
        assert page.evaluate(LOOK) == []


@pytest.mark.parametrize("both", [False, True], ids=["one", "two"])
@pytest.mark.parametrize("name", ["talking", "playback"])
@pytest.mark.parametrize("size", SIZES)
def test_scales_have_room_below_the_voice(stage: Stage, open_page: Open, size: str, name: str, both: bool) -> None:
    scenario = SCENARIOS[name]()
    scenario.state["voice"] = SCENARIOS["talking"]().state["voice"]
    stage.show(scenario)
    page = open_page(None, SIZES[size])
    page.wait_for_selector("#voice:not([hidden])")
    if both:
        page.keyboard.press("v")
    page.wait_for_timeout(500)  # the map is painted ten times a second, numbers four times
    assert page.evaluate(LOOK) == []


def test_it_is_compared_with_surroundings_mirror_image_and_the_map_before(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("t")
    wait_for_cell(page, 167, 107)
    warm, ground = (167, 107), (90, 107)  # 3 K of warmth at x 40 y -20; nothing at x -38
    wait_for_cell(page, *ground)
    page.select_option("#compare", "around")
    page.wait_for_function(
        f"({DIFFERENCE})(['temperature', 'around', {warm[0]}, {warm[1]}, 0]).then(value => value > 1.5)"
    )
    small = (
        f"({DIFFERENCE})(['temperature', 'around', {ground[0]}, {ground[1]}, 0]).then(value => Math.abs(value) < 0.3)"
    )
    page.wait_for_function(small)
    page.keyboard.press("b")
    assert page.input_value("#compare") == "mirror"
    axis = (warm[0] + ground[0] + 1) / 2
    here, there = (page.evaluate(DIFFERENCE, ["temperature", "mirror", *one, axis]) for one in (warm, ground))
    assert here == pytest.approx(-there, abs=1e-4)
    assert here > 2.5
    page.locator("#map-surface").hover(position={"x": 300, "y": 200})
    page.wait_for_selector("#read-out:has-text('mirrored: 36.4')")
    page.select_option("#compare", "before")
    page.wait_for_selector("#read-out:has-text('Keep as before')")
    page.click("#compare-set")
    assert page.evaluate(DIFFERENCE, ["temperature", "before", *warm, 0]) == 0.0


def test_a_mirror_line_is_set_where_the_cursor_is(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged", **TOUCH)
    page.select_option("#compare", "mirror")
    page.tap("#map-surface", position={"x": 150, "y": 200})
    wait_for(stage, "place", 2)  # the place and its mirror image
    at = view(page)
    page.tap("#compare-set")
    page.tap("#map-surface", position={"x": 450, "y": 200})
    axis_mm, place_mm = (at["left"] + x / at["scale"] for x in (150, 450))
    asked = [ask["details"]["x_mm"] for ask in wait_for(stage, "place", 4)[-2:]]
    assert asked == pytest.approx([place_mm, 2 * axis_mm - place_mm], abs=1.5)


def test_a_picture_from_a_file_lies_under_the_map_and_leaves_the_page_never(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    sent: list[str] = []
    page.on("request", lambda request: sent.append(request.url))
    page.click("#photo-button")
    page.set_input_files("#photo-file", {"name": "arm.png", "mimeType": "image/png", "buffer": png(40, 20)})
    page.wait_for_selector("#photo-adjust[aria-pressed=true]")
    before = view(page)
    page.mouse.move(500, 500)
    page.mouse.down()
    page.mouse.move(540, 500, steps=3)
    page.mouse.up()
    assert view(page) == before, "the drag moves the picture"
    page.click("#photo-larger")
    page.click("#photo-remove")
    page.wait_for_selector("#photo-remove[disabled]")
    assert sent == []
    page.set_input_files("#photo-file", {"name": "x.png", "mimeType": "image/png", "buffer": b"no picture"})
    page.wait_for_selector("#photo-said:has-text('no picture')")


def test_over_a_picture_the_colours_are_those_of_the_legend(open_page: Open) -> None:
    page = open_page("engaged")
    page.click("#photo-button")
    page.set_input_files("#photo-file", {"name": "arm.png", "mimeType": "image/png", "buffer": png(40, 20)})
    page.wait_for_function(f"() => {{ const c = ({COLOURS})(); return c.length > 1 && c.includes({WHITE}) }}")
    assert set(page.evaluate(COLOURS)) - {WHITE} <= set(page.evaluate(LEGEND))


def test_roughness_is_in_um_where_it_was_calibrated_and_never_in_volts(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("r")
    page.wait_for_selector("#legend .unit:has-text('of 10')")
    scenario = SCENARIOS["engaged"]()
    scenario.state["map"]["roughness_um"] = {"ln_um": 4.0, "exponent": 0.8, "ln_sd": 0.1, "holds_v": [0.02, 0.5]}
    stage.show(scenario)
    page.wait_for_selector("#legend .unit:has-text('µm')")
    page.focus("#map-view .equal")
    page.wait_for_selector("#map-table caption:has-text('Roughness, µm')")
    page.wait_for_selector("#properties dd:has-text('µm')")
    page.wait_for_selector("#legend .low:has-text('< 2.4')")  # um are known from 0.02 V to 0.5 V
    page.wait_for_selector("#legend .high:has-text('> 31')")
    scenario.state["map"]["roughness_um"]["holds_v"] = [0.02, 0.2]  # the finger has 0.231 V
    stage.show(scenario)
    page.wait_for_selector("#properties dd:has-text('of 10')")
    page.wait_for_selector("#legend .unit:has-text('µm')")


def test_the_next_place_to_press_and_its_name_do_not_stand_under_a_fingers_name(open_page: Open) -> None:
    page = open_page("engaged")
    page.wait_for_selector("#finger-table .force_n:not(:has-text('--'))")
    for dx in range(-42, 43, 6):
        for dy in range(-42, 43, 6):
            found = {word.pop("text"): word for word in page.evaluate(WORDS_AROUND_NEXT, [dx, dy])}
            assert not overlap(found["D2"], found["next"]), (dx, dy)
            assert not overlap(found["D2"], found["mark"]), (dx, dy)


def test_a_chosen_comparison_gives_the_letter_keys_back(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.focus("#compare")
    page.select_option("#compare", "mirror")
    page.keyboard.press("p")
    wait_for(stage, "disengage")
