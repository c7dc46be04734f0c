"""The patient's pain on the page: value and age, and the force limit with the act that ends it."""

from collections.abc import Callable
from typing import Any

import pytest

from tests.browser.conftest import SIZES, Open
from tests.browser.stage import Stage
from tests.browser.synthetic import painful, shifted, talking
from tests.browser.test_camera import LIVE_TEXT
from tests.browser.test_every_state import LOOK, axe_findings

pytestmark = pytest.mark.console

LEAST_PX = 240
"""Smallest height of the map."""


def test_pain_and_the_force_limit_are_shown_with_the_act_that_ends_it(open_page: Open) -> None:
    page = open_page("painful")
    page.wait_for_selector("#patient:has-text('Pain 6.0 of 10')")
    assert page.inner_text("#patient").split("\n") == [
        "Pain 6.0 of 10, 0.2 s old",
        "Force limited to 2.1 N by the patient's threshold.",
        "Remote side asks patient, then: teletaction session restore-force.",
        "Most tender near x 14 y 4 mm, ± 3 mm; pain from about 2.1 N; reaction about 0.6 s.",
    ]


@pytest.mark.parametrize("size", SIZES)
def test_beside_all_else_it_covers_nothing_and_leaves_room_for_the_map(
    stage: Stage, open_page: Open, picture_of: Callable[[Any, str], None], size: str
) -> None:
    scenario = stage.show("watching")
    scenario.shows(patient=painful().state["patient"], voice=talking().state["voice"])
    scenario.state["map"]["moved"] = shifted().state["map"]["moved"]
    page = open_page(size=SIZES[size])
    page.wait_for_selector(LIVE_TEXT)
    for tray in ("closed", "open"):
        assert page.evaluate(LOOK) + axe_findings(page) == []
        text, surface, tools = (page.locator(name).bounding_box() for name in ("#patient", "#map-view", "#map-tools"))
        assert text["y"] + text["height"] <= surface["y"]
        assert text["y"] >= tools["y"] + tools["height"] or text["y"] + text["height"] <= tools["y"]
        assert surface["height"] >= LEAST_PX
        picture_of(page, f"patient beside all else, tray {tray} {size}")
        page.click("#photo-button")


def test_a_new_line_does_not_move_a_picture_that_is_being_placed(stage: Stage, open_page: Open) -> None:
    scenario = stage.show("painful")
    scenario.state["patient"] |= {"limit": None, "ends": None, "tender": None}
    page = open_page()
    page.click("#photo-button")
    before = page.locator("#map-view").bounding_box()
    stage.show("painful")
    page.wait_for_selector("#patient:has-text('Force limited')")
    assert page.locator("#map-view").bounding_box() == before


def test_without_a_slider_there_is_no_line(open_page: Open) -> None:
    assert open_page("engaged").is_hidden("#patient")


def test_a_tender_finding_is_offered_only_with_the_patients_consent(open_page: Open) -> None:
    for name, offered in (("engaged", False), ("painful", True)):
        page = open_page(name)
        page.keyboard.press("f")
        page.wait_for_selector("#marking:not([hidden])")
        assert page.is_visible("#kinds button:has-text('tender')") == offered
        page.keyboard.press("7")
        pressed = page.locator("#kinds button:has-text('tender')").get_attribute("aria-pressed")
        assert (pressed == "true") == offered


def test_a_movement_of_the_patient_is_said(open_page: Open) -> None:
    page = open_page("shifted")
    page.wait_for_selector("#patient:has-text('Patient moved by about 5 mm towards the hand.')")


def test_without_data_the_patient_is_not_said_to_be_silent(stage: Stage, open_page: Open) -> None:
    page = open_page("painful")
    page.wait_for_selector("#patient:has-text('Pain 6.0 of 10')")
    stage.scenario.sends = False
    page.wait_for_selector("#patient:has-text('Pain: not live')")
