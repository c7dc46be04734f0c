"""A recording on the page: it says that it is one, offers no live order, and its time line says what happened when."""

import math
from typing import Any

import pytest

from tests.browser.conftest import Open, wait_for
from tests.browser.stage import Stage

pytestmark = pytest.mark.console

LIVE_ORDERS = ("#stop", "#act-button", "#finding-button", "#note-button", "[data-undo]", "[data-edit]", "#take-button")
SHEET_ORDERS = ("#begin-form", "#end-button", "#sound-play", "#sound-heard", "#sound-refused", "#quiet-button")


def test_it_says_playback_and_the_date_and_offers_no_live_order(open_page: Open) -> None:
    page = open_page("playback")
    assert page.inner_text("#state-word") == "PLAYBACK"
    assert page.inner_text("#recording") == "3 Nov 2026 14:07"
    for order in LIVE_ORDERS:
        assert not page.is_visible(order), order
    page.click("#session-button")
    page.wait_for_selector("#sheet-session:not([hidden])")
    for order in SHEET_ORDERS + LIVE_ORDERS:
        assert not page.is_visible(order), order


def test_keys_of_live_orders_do_nothing(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    for key in ("e", "e", "p", "c", "c", "f", "n", "q", "Escape"):
        page.keyboard.press(key)
    page.keyboard.press(" ")
    wait_for(stage, "pause")
    assert {ask["verb"] for ask in stage.asks} <= {"pause", "place"}


def test_arrows_on_the_map_move_its_cursor_and_not_the_time(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    page.click("[data-jump='1']")
    wait_for(stage, "seek")
    page.focus("#map-surface")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowLeft")
    page.wait_for_selector("#read-out:has-text('x 36 y -20 mm')")
    page.focus("#play-button")
    page.keyboard.press("ArrowRight")
    assert [ask["details"] for ask in wait_for(stage, "seek", 2)] == [{"at_s": 311.0}, {"at_s": 312.0}]


def test_brackets_jump_from_mark_to_mark_and_say_it(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    page.keyboard.press("]")
    (sought,) = wait_for(stage, "seek")
    assert sought["details"] == {"at_s": 402.0}
    assert page.inner_text("#mark-said") == "00:06:42 finding: 2: stiff, 4000 ± 400 N/m"
    page.keyboard.press("]")
    wait_for(stage, "seek", 2)
    assert page.inner_text("#mark-said") in ("00:08:20 fault: index plate 45.2 °C, over 45.0", "00:08:20 state: FAULT")
    for _ in range(3):
        page.keyboard.press("[")
    assert wait_for(stage, "seek", 5)[-1]["details"] == {"at_s": 120.0}
    assert page.inner_text("#mark-said") == "00:02:00 alarm: Link slow"


def place_of(page: Any, at_s: float) -> tuple[float, float]:
    box = page.locator("#ticks").bounding_box()
    return box["x"] + box["width"] * at_s / 761.2, box["y"] + 8


@pytest.mark.parametrize("way", ["mouse", "touch"])
def test_a_mark_says_what_and_when_and_is_jumped_to(stage: Stage, open_page: Open, way: str) -> None:
    page = open_page("playback", has_touch=way == "touch")
    place = place_of(page, 120.0)
    if way == "mouse":
        page.mouse.move(*place)
        assert page.inner_text("#mark-said") == "00:02:00 alarm: Link slow"
        page.mouse.click(*place)
    else:
        page.touchscreen.tap(*place)
    (sought,) = wait_for(stage, "seek")
    assert sought["details"] == {"at_s": 120.0}
    assert page.inner_text("#mark-said") == "00:02:00 alarm: Link slow"


@pytest.mark.parametrize("by", ["click", "keyboard"])
def test_a_finding_of_the_list_is_jumped_to_in_place_and_time(stage: Stage, open_page: Open, by: str) -> None:
    page = open_page("playback")
    page.locator("[data-jump='1']").click() if by == "click" else page.locator("[data-jump='1']").press("Enter")
    (sought,) = wait_for(stage, "seek")
    assert sought["details"] == {"at_s": 311.0}
    assert page.inner_text("#mark-said") == "00:05:11 finding: 1: warm, 36.4 ± 0.2 °C"
    page.wait_for_selector("#read-out:has-text('x 40 y -20 mm')")
    del stage.scenario.state["findings"][0]  # when it was marked, it was not saved
    page.wait_for_selector("[data-jump='1']", state="detached")
    assert page.evaluate("document.activeElement.id") == "ticks", "keys continue there"


def test_a_finding_of_a_later_examination_is_jumped_to(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    stage.scenario.state["session"]["playback"]["marks"].append(
        {"at_s": 700.0, "kind": "finding", "text": "1: cold, 28.0 ± 0.2 °C"}
    )
    stage.scenario.state["findings"][0].update(at_s=700.0, kind="cold", text="cold, 28.0 ± 0.2 °C")
    page.click("[data-jump='1']:has-text('cold')")
    assert wait_for(stage, "seek")[0]["details"] == {"at_s": 700.0}


def test_a_finding_without_a_place_is_jumped_to_in_time(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    stage.scenario.state["findings"][1].update(x_mm=None, y_mm=None)
    page.click("[data-jump='2']:has-text('no place')")
    assert wait_for(stage, "seek")[0]["details"] == {"at_s": 402.0}


def test_the_focused_time_line_says_the_newest_mark(open_page: Open) -> None:
    page = open_page("playback")
    page.focus("#ticks")
    assert page.inner_text("#mark-said") == "00:05:11 finding: 1: warm, 36.4 ± 0.2 °C"


def test_states_and_marks_have_words_and_shapes(open_page: Open) -> None:
    page = open_page("playback")
    assert page.inner_text("#modes").split("\n") == ["ENGAGED", "FAULT"]
    uses = page.eval_on_selector_all("#ticks use", "uses => uses.map(use => use.getAttribute('href'))")
    assert uses == ["#shape-alarm", "#shape-finding", "#shape-finding", "#shape-fault"]
    assert "1: warm" in page.inner_text("#ticks")


def test_a_preview_says_what_follows(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    stage.scenario.state["session"]["playback"]["partial"] = True
    page.wait_for_selector("#played:has-text('Map and last 10 s follow.')")


def test_a_limit_of_a_later_moment_is_not_shown_after_a_jump_back(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    stage.scenario.limited = {1}
    page.wait_for_selector("#finger-table .limit")
    stage.scenario.limited = set()
    stage._started += 60.0
    page.wait_for_selector("#finger-table .limit", state="detached", timeout=2500)


@pytest.mark.real_time(stall_s=math.inf)
def test_a_jump_into_another_contact_begins_the_chart_anew(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    page.wait_for_function("() => import('/page/now.js').then(({ now }) => now.state.fingers[1].contact_s > 0.5)")
    stage.scenario.converges = False
    stage.scenario.state["session"]["playback"]["at_s"] = 500.0
    for finger in stage.scenario.state["fingers"]:
        finger |= {"contact_s": 6.0, "candidates": [["rubber", 0.97]]}
    page.wait_for_function("() => import('/page/now.js').then(({ now }) => now.state.fingers[1].contact_s === 6)")
    page.keyboard.press("d")
    page.keyboard.press("2")
    page.focus("#chart .equal")
    page.wait_for_selector("#chart-table:has-text('97 %')")
    assert page.locator("#chart-table tr").all_inner_texts()[1:] == ["6.0\trubber\t97 %"]


def test_a_chosen_speed_gives_the_keys_back(stage: Stage, open_page: Open) -> None:
    page = open_page("playback")
    page.focus("#speed")
    page.select_option("#speed", "4")
    assert wait_for(stage, "play")[0]["details"] == {"speed": 4}
    page.keyboard.press("Space")
    wait_for(stage, "pause")


def test_a_speed_is_chosen_before_it_is_played(stage: Stage, open_page: Open) -> None:
    stage.show("playback").state["session"]["playback"]["playing"] = False
    page = open_page()
    page.wait_for_selector("#play-button:has-text('Play')")
    assert page.input_value("#speed") == "1"
    page.select_option("#speed", "4")
    page.wait_for_timeout(500)  # a few states
    page.keyboard.press("Space")
    assert wait_for(stage, "play")[0]["details"] == {"speed": 4}
