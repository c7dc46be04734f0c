"""The patient's pain on the page: value and age, and the force limit with the act that ends it."""

import pytest

from tests.browser.conftest import Open

pytestmark = pytest.mark.console


def test_pain_and_the_force_limit_are_shown_with_the_act_that_ends_it(open_page: Open) -> None:
    page = open_page("painful")
    page.wait_for_selector("#patient:has-text('Pain 6.0 of 10')")
    assert page.inner_text("#patient").split("\n") == [
        "Pain 6.0 of 10, 0.2 s old",
        "Force limited to 2.1 N by the patient's threshold.",
        "Remote side asks patient, then: teletaction session restore-force.",
    ]


def test_without_a_slider_there_is_no_line(open_page: Open) -> None:
    assert open_page("engaged").is_hidden("#patient")
