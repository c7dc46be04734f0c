"""The page in a real browser on a real console: an operator site on a virtual environment with simulated devices."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.console.conftest import LIVE
from tests.console.test_every_state import LOOK, axe_findings
from tests.session.live_console import Session, running
from tests.session.truth import written

pytestmark = [pytest.mark.console, pytest.mark.timeout(300)]


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    with running(tmp_path_factory.mktemp("live")) as session:
        yield session


def opened(browser: Any, session: Session, path: str = "/") -> Any:
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.set_default_timeout(20_000)
    page.goto(session.address + path)
    page.wait_for_selector(LIVE)
    return page


def hold(page: Any, key: str) -> None:
    page.keyboard.down(key)
    page.wait_for_timeout(1200)  # longer than the second that a held key takes
    page.keyboard.up(key)


def test_a_whole_session_from_its_beginning_to_its_report(
    browser: Any, session: Session, picture_of: Callable[[Any, str], None]
) -> None:
    page = opened(browser, session)
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.wait_for_selector("body[data-shown=connected]")
    picture_of(page, "live connected")
    page.click("#sound-refused")
    page.fill("#begin-pseudonym", "Anna Meier")
    page.keyboard.press("Enter")
    page.wait_for_selector("#begin-said:has-text('Use a study number, not a name.')")
    page.fill("#begin-pseudonym", "P-0417")
    page.keyboard.press("Enter")
    page.wait_for_selector("#act-button:has-text('Engage')")
    hold(page, "e")
    page.wait_for_selector("body[data-shown=engaged]")
    page.wait_for_selector("#told-title:has-text('since contact')")
    page.wait_for_selector("#legend-high:not(:empty)")
    picture_of(page, "live engaged")
    assert page.evaluate(LOOK) + axe_findings(page) == []

    page.keyboard.press("f")
    page.keyboard.press("1")
    page.keyboard.press("Enter")
    page.wait_for_selector("#read-out:has-text('Finding 1 ')")
    page.wait_for_selector("#findings li", state="attached")
    page.keyboard.press("n")
    page.keyboard.type("rough <b>here</b>")
    page.click("#noting [type=submit]")
    page.wait_for_selector("#read-out:has-text('Note to finding 1 ')")

    page.keyboard.press("Space")
    page.wait_for_selector("#answers-title:has-text('STOPPED. All 3 devices confirmed in 0.')")
    assert page.locator("#answers-list li.stopped").count() == 3
    stopped_s = time.monotonic()
    assert page.inner_text("#state-word") == "STOPPED"
    picture_of(page, "live stopped")
    page.wait_for_timeout(500)  # what the devices do afterwards is in the truth
    truth = written(session.folder / "sim-operator.mcap", "truth_fingertips", stopped_s, may_be_cut=True)
    assert truth
    assert max(force_n for _, entry in truth for force_n in entry["force_n"]) == 0.0
    hold(page, "c")
    page.wait_for_selector("body:is([data-shown=connected], [data-shown=paused])")

    page.click("#session-button")
    page.click("#end-button")
    page.click("#end-button:has-text('End session P-0417? 1 finding.')")
    page.wait_for_selector("#report-link:visible")
    picture_of(page, "live ended")
    with page.context.expect_page() as opening:
        page.click("#report-link")
    report = opening.value.locator("body")
    assert "P-0417" in report.inner_text()
    assert "rough <b>here</b>" in report.inner_text()
    assert wrong == []
    page.close()


def test_a_reload_and_a_second_tab_in_mid_session(browser: Any, session: Session) -> None:
    page = opened(browser, session)
    page.click("#sound-refused")
    page.fill("#begin-pseudonym", "P-0418")
    page.keyboard.press("Enter")
    page.wait_for_selector("#act-button:has-text('Engage')")
    hold(page, "e")
    page.wait_for_selector("body[data-shown=engaged]")
    page.reload()
    page.wait_for_selector("body[data-shown=engaged]")
    second = opened(browser, session)
    second.wait_for_selector("body[data-shown=engaged]")
    assert second.inner_text("#pseudonym") == "P-0418"
    second.keyboard.press("Space")
    for tab in (page, second):
        tab.wait_for_selector("body[data-shown=stopped]")
    page.close()
    second.close()


def test_an_observer_sees_and_has_nothing_to_press(browser: Any, session: Session) -> None:
    page = opened(browser, session, "/?role=observe")
    page.wait_for_selector("#looking-on:has-text('OBSERVER.')")
    assert not page.is_visible("#stop")
    assert not page.is_visible("#act-button")
    page.close()
