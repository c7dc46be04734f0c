"""Clutch and motion scale on the page: button, key and pedal, what is shown, and who may not."""

from typing import Any

import pytest

from tests.browser.conftest import Open, wait_for
from tests.browser.stage import Stage

pytestmark = pytest.mark.console


def asked(stage: Stage, verb: str, count: int = 1) -> list[dict[str, Any]]:
    wait_for(stage, verb, count)
    return [ask["details"] for ask in stage.asks if ask["verb"] == verb]


def test_the_button_opens_and_closes_the_clutch_and_the_bar_says_so(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    assert page.inner_text("#coupling") == ""
    page.click("#clutch-button")
    assert asked(stage, "clutch") == [{"open": True}]
    page.wait_for_selector("#coupling:has-text('clutch open')")
    assert page.get_attribute("#clutch-button", "aria-pressed") == "true"
    page.click("#clutch-button:has-text('Close clutch')")
    assert asked(stage, "clutch", 2) == [{"open": True}, {"open": False}]
    page.wait_for_selector("#clutch-button[aria-pressed=false]")


@pytest.mark.parametrize("key", ["g", "F9"])
def test_a_held_key_or_pedal_holds_the_clutch_open(stage: Stage, open_page: Open, key: str) -> None:
    page = open_page("engaged")
    for _ in range(4):  # the first press, and its repetitions
        page.keyboard.down(key)
    assert asked(stage, "clutch") == [{"open": True}]
    page.keyboard.up(key)
    assert asked(stage, "clutch", 2) == [{"open": True}, {"open": False}]


def test_the_pedal_works_while_typing_and_the_letter_types(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.keyboard.press("n")
    page.keyboard.type("g")
    page.keyboard.press("F9")
    assert asked(stage, "clutch", 2) == [{"open": True}, {"open": False}]
    assert page.input_value("#note-text").endswith("g")


def test_the_scale_is_chosen_from_a_list_that_gives_the_keys_back(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.select_option("#scale", "5")
    assert asked(stage, "scale") == [{"scale": 5}]
    page.wait_for_selector("#coupling:has-text('1:5')")
    page.keyboard.press("g")
    assert asked(stage, "clutch", 2) == [{"open": True}, {"open": False}]


def test_a_refused_scale_is_said_and_the_list_shows_the_present_one(stage: Stage, open_page: Open) -> None:
    stage.answers["scale"] = lambda _: {"ok": False, "text": "a finger presses: lift it"}
    page = open_page("engaged")
    page.select_option("#scale", "2")
    page.wait_for_selector("#polite:has-text('a finger presses')", state="attached")
    assert page.input_value("#scale") == "1"


def test_edges_of_the_workspace_are_named_in_the_bar(open_page: Open) -> None:
    page = open_page("clutched")
    page.wait_for_selector("#coupling:has-text('edge')")
    assert page.inner_text("#coupling").split("\n") == ["1:5", "clutch open", "edge: x+, low"]


@pytest.mark.parametrize("state", ["connected", "paused", "fault", "observer", "elsewhere", "playback"])
def test_where_it_is_not_possible_nothing_is_asked(stage: Stage, open_page: Open, state: str) -> None:
    page = open_page(state)
    button = page.locator("#clutch-button")
    assert not button.is_visible() or button.is_disabled()
    page.keyboard.press("g")
    page.keyboard.press("F9")
    page.keyboard.press("t")  # a later request shows that none came before
    assert [ask for ask in stage.asks if ask["verb"] in ("clutch", "scale")] == []


@pytest.mark.parametrize("size", [(1440, 900, 1), (1280, 800, 1), (1024, 768, 1)])
def test_an_open_clutch_moves_nothing_else(stage: Stage, open_page: Open, size: tuple[int, int, int]) -> None:
    page = open_page("engaged", size)
    before = page.locator("#finger-table").bounding_box()
    page.click("#clutch-button")
    page.wait_for_selector("#clutch-button:has-text('Close clutch')")
    assert page.locator("#finger-table").bounding_box() == before
