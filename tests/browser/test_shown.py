"""The state on the page is never more than is live: whatever falls silent, whatever stops."""

from typing import Any

import pytest

from tests.browser.conftest import Open, wait_for
from tests.browser.stage import Stage

pytestmark = pytest.mark.console

PROPERTY = """async () => {
  const { ACTING, OF_LINK, SILENT_S, STATE_SILENT_S, shownWord, silence } = await import('/page/shown.js');
  const words = ['disconnected', 'connected', 'engaging', 'engaged', 'paused', 'lost', 'fault', 'stopped', 'silent'];
  const one = list => list[Math.floor(Math.random() * list.length)];
  const age = () => one([0, 0.1, 0.5, 0.500001, 1, 1.000001, 30, NaN, Infinity, -1, 2 * Math.random()]);
  const wrong = [], shown = new Set();
  for (let tried = 0; tried < 50000; tried += 1) {
    const picture_s = one([age(), null]), state_s = age(), state = one([...words, null]);
    const drawn = one([null, 0, 1, 2, 3]);
    const stopping = Math.random() < 0.3, silent_s = silence(picture_s, state_s);
    const word = shownWord({ state, drawn, silent_s, stopping });
    const young = (age_s, limit_s) => age_s >= 0 && age_s <= limit_s;
    const live = (picture_s === null || young(picture_s, SILENT_S)) && young(state_s, STATE_SILENT_S);
    shown.add(word);
    if ((silent_s === 0) !== live) wrong.push(['silence', picture_s, state_s, silent_s]);
    const allowed = live && !stopping && state !== 'silent' && state !== null;
    if (ACTING.includes(word) && !allowed) wrong.push([word, state, drawn]);
    if (word === 'engaged' && drawn !== null && OF_LINK[drawn] !== 'engaged') wrong.push([word, state, drawn]);
  }
  return [wrong.slice(0, 5), [...shown].sort()];
}"""

WATCH = """() => {
  window.green = [];
  const look = () => {
    const shown = document.body.dataset.shown, alarm = document.getElementById('alarm-text').textContent;
    if (['engaged', 'engaging'].includes(shown) && /not live|LINK LOST/.test(alarm)) window.green.push([shown, alarm]);
  };
  const everything = { attributes: true, subtree: true, childList: true, characterData: true };
  new MutationObserver(look).observe(document.body, everything);
}"""
"""Keeps each moment in which a state that acts stood over an alarm that says it is not live."""


def test_no_age_above_its_limit_is_shown_as_engaged(open_page: Open) -> None:
    wrong, shown = open_page("engaged").evaluate(PROPERTY)
    assert wrong == []
    assert {"engaged", "engaging", "lost", "stopping", "unknown"} <= set(shown), "each was tried"


def test_engaged_never_stands_over_an_alarm_that_nothing_is_live(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.evaluate(WATCH)
    stage.show("silent")
    page.wait_for_selector("body[data-shown=unknown]")
    page.wait_for_selector("#alarm-text:has-text('Screen is not live.')")
    assert page.evaluate("window.green") == []


def test_a_console_that_says_its_site_is_silent_is_not_live(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.evaluate(WATCH)
    scenario = stage.show("engaged")
    scenario.alarm("feed", "high", "No data for 1.9 s. Screen is not live.").session(state="silent")
    page.wait_for_selector("body[data-shown=unknown]")
    assert page.inner_text("#state-word") == "NOT LIVE"
    assert page.is_disabled("#act-button")
    assert [page.inner_text(place) for place in ("#recording", "#delay", "#clock")] == ["--"] * 3
    page.keyboard.press("Space")
    wait_for(stage, "estop")
    assert page.evaluate("window.green") == []


def test_a_lost_link_is_no_engaged_state_and_can_be_stopped_and_paused(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    stage.show("lost")
    page.wait_for_selector("body[data-shown=lost]")
    assert page.inner_text("#state-word") == "LINK LOST"
    assert "Pause" in page.inner_text("#act-button")
    page.keyboard.press("Space")
    wait_for(stage, "estop")


ENGAGING_SAID = """() => {
  const polite = document.getElementById('polite');
  const look = () => { window.said ||= polite.textContent === 'ENGAGING'; };
  new MutationObserver(look).observe(polite, { childList: true });
}"""


def test_a_stop_cancels_what_was_answered_of_engaging(stage: Stage, open_page: Open) -> None:
    def engage(_: dict[str, Any]) -> dict[str, Any]:
        stage.scenario.session(state="engaging")
        return {"text": "ENGAGING"}

    stage.answers["engage"] = engage
    page = open_page("ready")
    page.evaluate(ENGAGING_SAID)
    page.evaluate("import('/page/actions.js').then(actions => actions.ask('engage'))")
    page.wait_for_function("() => window.said")
    page.wait_for_selector("body[data-shown=engaging]")
    page.keyboard.press("Space")
    page.wait_for_selector("body[data-shown=stopped]")
    page.wait_for_function("() => !document.body.innerText.includes('ENGAGING')", timeout=4_000)


DRAWN_LATE = """async () => {
  const { now, shownState } = await import('/page/now.js');
  const early = { state: { value: 2 }, came_ms: { value: now.stateAt_ms - 1 } };
  now.picture = Object.create(now.picture, early);
  now.pictureAt_ms = performance.now();
  return shownState();
}"""


def test_a_picture_that_came_before_a_state_says_nothing_of_it_however_late_it_is_drawn(open_page: Open) -> None:
    assert open_page("paused").evaluate(DRAWN_LATE) == "paused"


OFFERED = """() => [...document.querySelectorAll('#act-button, #finding-button, #sheet-session button:not(.close)')]
  .filter(button => !button.disabled).map(button => button.id || button.textContent)"""


@pytest.mark.parametrize("cut", ["connection", "console", "site"])
def test_without_data_nothing_is_offered_and_nothing_is_ticked(stage: Stage, open_page: Open, cut: str) -> None:
    page = open_page("connected")
    page.wait_for_selector("#ready li:has-text('✓')")
    page.wait_for_selector("#begin-form button:enabled")
    if cut == "connection":
        stage.cut()
    elif cut == "console":
        stage.scenario.sends = False
    else:
        stage.scenario.session(state="silent")
    page.wait_for_selector("body[data-shown=unknown]")
    page.wait_for_selector("#checks li:has-text('not live')")
    page.wait_for_selector("#stop-key:has-text('not live')")
    assert page.locator("#ready li").count() == 0
    assert page.evaluate(OFFERED) == []
    assert [page.inner_text(place) for place in ("#clock", "#delay", "#recording")] == ["--"] * 3
    assert page.is_enabled("#stop")
    assert (page.get_attribute("body", "data-connected") == "false") == (cut == "connection")
