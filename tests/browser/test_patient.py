"""The patient's pain on the page: value and age, and the force limit with the act that ends it."""

import pytest

from tests.browser.conftest import SIZES, Open
from tests.browser.stage import Stage
from tests.browser.synthetic import painful
from tests.browser.test_camera import LIVE_TEXT
from tests.browser.test_every_state import LOOK

pytestmark = pytest.mark.console


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
def test_the_cameras_picture_covers_none_of_it(stage: Stage, open_page: Open, size: str) -> None:
    stage.show("watching").state["patient"] = painful().state["patient"]
    page = open_page(size=SIZES[size])
    page.wait_for_selector(LIVE_TEXT)
    assert page.evaluate(LOOK) == []
    over = [page.eval_on_selector(name, "e => Number(getComputedStyle(e).zIndex)") for name in ("#patient", "#camera")]
    assert over[0] > over[1]
    text, picture = (page.locator(name).bounding_box() for name in ("#patient", "#camera"))
    if SIZES[size][2] == 1:  # at a zoom of 200 % the text lies over the picture
        assert text["y"] + text["height"] <= picture["y"]


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
