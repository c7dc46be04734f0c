"""STOP: by click, by key from any focus, while typing, repeated until answered, after a cut; what the devices say."""

from typing import Any

import pytest

from tests.browser import synthetic
from tests.browser.conftest import Open, wait_for
from tests.browser.stage import Stage

pytestmark = pytest.mark.console

FOCUSABLE = """() => [...document.querySelectorAll('button, select, canvas[tabindex], .equal')].map((e, at) => [at, e])
  .filter(([, e]) => e.checkVisibility({ visibilityProperty: true }) && !e.disabled).map(([at]) => at)"""
FOCUS = "at => [...document.querySelectorAll('button, select, canvas[tabindex], .equal')][at].focus()"


def chips(page: Any) -> list[str]:
    texts: list[str] = page.locator("#answers-list li").all_inner_texts()
    return [" ".join(text.split()) for text in texts]


def test_pressing_acts_before_the_release_and_shows_what_the_devices_answered(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    box = page.locator("#stop").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    wait_for(stage, "estop")
    page.wait_for_selector("body[data-shown=stopped]")
    page.mouse.up()
    assert page.inner_text("#answers-title") == "STOPPED. All 7 devices confirmed in 0.06 s."
    assert chips(page) == [
        f"{label} stopped 0.06 s" for label in ("D1", "D2", "D3", "D4", "D5", "exoskeleton", "remote hand")
    ]


@pytest.mark.parametrize("key", ["Space", "Escape"])
def test_the_key_stops_from_any_focus_and_nothing_else_happens(stage: Stage, open_page: Open, key: str) -> None:
    page = open_page("engaged")
    places = page.evaluate(FOCUSABLE)
    assert len(places) > 12
    for count, place in enumerate(places, start=1):
        stage.show("engaged")
        page.wait_for_selector("body[data-shown=engaged]")
        page.evaluate(FOCUS, place)
        page.keyboard.press(key)
        wait_for(stage, "estop", count)
        page.wait_for_selector("body[data-shown=stopped]")
    assert {ask["verb"] for ask in stage.asks} <= {"estop", "place"}


@pytest.mark.parametrize("state", ["engaging", "paused"])
def test_space_stops_while_engaging_and_paused(stage: Stage, open_page: Open, state: str) -> None:
    page = open_page(state)
    assert page.inner_text("#stop-key") == "Space"
    page.keyboard.press("Space")
    wait_for(stage, "estop")


def test_outside_a_session_space_presses_the_button_that_has_the_focus(stage: Stage, open_page: Open) -> None:
    page = open_page("connected")
    page.locator("#sound-play").focus()
    page.keyboard.press("Space")
    page.wait_for_selector("#sound-heard:visible")
    assert stage.asks == []


def test_in_a_text_field_space_types_and_escape_stops(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("n")
    page.keyboard.type("two words")
    assert page.input_value("#note-text").endswith("two words")
    assert page.inner_text("#stop-key") == "Esc"
    assert [ask for ask in stage.asks if ask["verb"] == "estop"] == []
    page.keyboard.press("Escape")
    wait_for(stage, "estop")
    assert page.input_value("#note-text").endswith("two words")


def test_the_key_under_stop_is_one_that_stops(open_page: Open) -> None:
    page = open_page("connected")
    page.focus("#begin-pseudonym")
    page.wait_for_timeout(300)  # the focus is followed
    assert page.inner_text("#stop-key") == "press here"


def test_a_held_key_is_one_stop(stage: Stage, open_page: Open) -> None:
    stage.answers["estop"] = lambda _: {}
    page = open_page("engaged")
    for _ in range(5):
        page.keyboard.down("Space")
    asks = wait_for(stage, "estop")
    assert {ask["id"] for ask in asks} == {asks[0]["id"]}


def test_it_is_sent_again_under_the_same_id_until_it_is_answered(stage: Stage, open_page: Open) -> None:
    unanswered = iter(range(5))
    stage.answers["estop"] = lambda _: {"ok": None} if next(unanswered, None) is not None else {}
    page = open_page("engaged")
    page.keyboard.press("Space")
    asks = wait_for(stage, "estop", 6)
    assert {ask["id"] for ask in asks} == {asks[0]["id"]}
    assert page.get_attribute("body", "data-shown") == "stopping"
    stage.scenario.state["stop"] = synthetic.stop_of(dict.fromkeys(synthetic.DEVICES, 0.09), late=False)
    stage.scenario.session(state="stopped")
    page.wait_for_selector("body[data-shown=stopped]")
    seen = len(stage.asks)
    page.wait_for_timeout(200)  # four more periods of the repetition
    assert len([ask for ask in stage.asks[seen:] if ask["verb"] == "estop"]) == 0


def test_the_page_shows_what_the_site_says_and_never_its_own_wish(stage: Stage, open_page: Open) -> None:
    stage.answers["estop"] = lambda _: {}
    page = open_page("engaged")
    page.keyboard.press("Space")
    page.wait_for_selector("body[data-shown=stopping]")
    stage.scenario.state["stop"] = synthetic.stop_of({"thumb": 0.05}, late=False)
    page.wait_for_selector("#answers-list li.stopped")
    assert chips(page) == ["D1 stopped 0.05 s"] + [
        f"{label} waiting" for label in ("D2", "D3", "D4", "D5", "exoskeleton", "remote hand")
    ]
    assert page.get_attribute("body", "data-shown") == "stopping"
    assert page.is_disabled("#act-button")


def test_devices_that_do_not_answer_are_named_and_marked(open_page: Open) -> None:
    page = open_page("stop_not_confirmed")
    said = "STOP NOT CONFIRMED: Index, remote hand. Use the hardware switch."
    assert page.inner_text("#alarm-text") == said
    assert page.inner_text("#answers-title") == said
    assert page.locator("#answers-list li.late").all_inner_texts() == ["D2\nwaiting", "remote hand\nwaiting"]
    assert not page.is_visible("#quiet-button")
    assert page.inner_text("#urgent") == said


def test_without_a_connection_it_says_so_and_is_the_first_thing_sent_when_there_is_one(
    stage: Stage, open_page: Open
) -> None:
    page = open_page("engaged")
    stage.cut()
    page.wait_for_selector("body[data-shown=unknown]")
    page.wait_for_selector("#stop-key:has-text('not live')")
    page.keyboard.press("Space")
    page.wait_for_selector("#alarm[data-priority=high]")
    assert page.inner_text("#alarm-text") == "STOP NOT SENT. Use the hardware switch."
    heard = len(stage.asks)
    stage.mend()
    wait_for(stage, "estop")
    assert stage.asks[heard]["verb"] == "estop"
    page.wait_for_selector("body[data-shown=stopped]")


def test_an_observer_and_a_recording_have_no_stop(open_page: Open) -> None:
    for scenario in ("observer", "playback"):
        page = open_page(scenario)
        assert not page.is_visible("#stop")
        assert not page.is_visible("#act-button")
    assert page.inner_text("#state-word") == "PLAYBACK"
