"""The page's end of the websocket: credit, reconnecting, reloading, two tabs, sleeping, silence, and broken frames."""

import math
import random
import time
from contextlib import closing
from typing import Any

import pytest

from operator_site.console.state.signals import SPAN_S
from operator_site.console.web.clients import CREDIT
from tests.browser import synthetic
from tests.browser.conftest import Open
from tests.browser.lossy_way import LossyWay
from tests.browser.stage import Client, Stage

pytestmark = pytest.mark.console

SLOW = """const frame = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = draw => setTimeout(() => frame(draw), 200);"""

HIDEABLE = """
  let hidden = false, waiting = [];
  const frame = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = draw => frame(at_ms => hidden ? waiting.push(draw) : draw(at_ms));
  Object.defineProperty(document, 'hidden', { get: () => hidden });
  window.hide = now => {
    hidden = now;
    document.dispatchEvent(new Event('visibilitychange'));
    if (!hidden) waiting.splice(0).forEach(frame);
  };
"""
"""A hidden page gets no animation frames, while timers and messages continue. (Under automation no page is hidden.)"""


def until(true: Any) -> None:
    """Wait for something on the stage, which runs in another thread."""
    end = time.monotonic() + 10
    while not true():
        assert time.monotonic() < end
        time.sleep(0.01)


def only(stage: Stage) -> Client:
    until(lambda: len(stage.clients) == 1)
    return stage.clients[0]


def test_a_slow_page_never_has_more_than_two_pictures_under_way(stage: Stage, open_page: Open) -> None:
    open_page("engaged", script=SLOW)
    client = only(stage)
    until(lambda: len(client.delays_s) >= 12)
    assert client.most_under_way == CREDIT
    assert client.skipped > client.sent
    # It is at most its own time to draw behind, twice: no queue grows.
    assert max(client.delays_s[-4:]) < 1.5 * max(client.delays_s[:4])


def test_a_lost_connection_is_shown_and_comes_back_by_itself(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    stage.cut()
    page.wait_for_selector("body[data-shown=unknown]")
    assert page.inner_text("#state-word") == "NOT LIVE"
    page.wait_for_selector("#alarm[data-priority=high]")
    assert page.inner_text("#alarm-text") == "No connection to the console. Trying again."
    page.wait_for_selector("#finger-table td.force_n:has-text('--')")
    assert page.inner_text("#delay") == "--"
    stage.mend()
    page.wait_for_selector("body[data-shown=engaged]")
    page.wait_for_selector("#alarm[data-priority=none]")


@pytest.mark.real_time(stall_s=math.inf)
def test_the_picture_comes_back_with_the_session_after_connections_were_lost_silently(
    stage: Stage, open_page: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    with closing(LossyWay(stage.url)) as way:
        monkeypatch.setattr(Stage, "url", way.url)
        page = open_page("watching")
        page.wait_for_selector("#camera-said:has-text('Picture 0.')")
        way.lose()
        page.wait_for_selector("#camera-said:has-text('frozen')")
        page.wait_for_selector("body[data-shown=unknown]")
        page.wait_for_selector("#camera-said:has-text('Picture 0.')")
        assert page.get_attribute("body", "data-shown") != "unknown"


def test_a_console_that_falls_silent_raises_the_pages_own_alarm(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.wait_for_selector("#object:has-text('24')")
    stage.show("silent")
    page.wait_for_selector("#alarm[data-priority=high]")
    assert "Screen is not live." in page.inner_text("#alarm-text")
    page.wait_for_selector("body[data-shown=unknown]")
    page.wait_for_selector("#decision:has-text('--')")
    assert page.inner_text("#object") == "object -- °C"


UNANSWERED = """
  window.WebSocket = new Proxy(WebSocket, { construct: (real, [address]) => (window.lost
    ? Object.assign(new EventTarget(), { readyState: 0, send() {}, close() {} }) : new real(address)) });
"""
"""A network that drops what a browser sends to open a connection, while `lost`."""


def test_a_connection_that_does_not_open_is_tried_again(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged", script=UNANSWERED)
    page.evaluate("window.lost = true")
    stage.close_all()
    page.wait_for_selector("body[data-connected=false]")
    page.wait_for_timeout(1000)  # it tries
    page.evaluate("window.lost = false")
    page.wait_for_selector("body[data-shown=engaged]")


def test_no_old_alarm_stands_before_the_pages_own(stage: Stage, open_page: Open) -> None:
    page = open_page("fault")
    page.wait_for_selector("#alarm-text:has-text('LINK LOST. Outputs are neutral.')")
    stage.scenario.sends = False
    page.wait_for_selector("#alarm-text:has-text('Screen is not live.')")
    assert page.get_attribute("#alarm", "data-priority") == "high"
    assert page.inner_text("#alarm-button") == "+2 (A)"


def test_an_alarms_age_is_not_shown_while_nothing_is_heard(stage: Stage, open_page: Open) -> None:
    page = open_page("stop_not_confirmed")
    page.wait_for_selector("#alarm-age:has-text('for 1 min')")
    stage.scenario.sends = False
    page.wait_for_selector("#alarm-age", state="hidden")
    assert "STOP NOT CONFIRMED" in page.inner_text("#alarm-text")


def test_before_the_first_state_nothing_can_be_pressed_in_vain(stage: Stage, browser: Any) -> None:
    stage.show("silent")
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.goto(stage.url)
    page.wait_for_selector("#alarm-text:has-text('Screen is not live.')")
    assert page.is_disabled("#session-button")
    assert page.is_disabled("#clutch-button")
    assert "Clutch" in page.inner_text("#clutch-button")
    page.close()


def test_old_values_turn_grey_with_their_age_and_then_vanish(stage: Stage, open_page: Open) -> None:
    page = open_page("missing_devices")
    page.wait_for_selector("td.force_n.stale")
    middle = page.locator("td.remarks, tr.remarks td").nth(2)
    assert middle.inner_text().startswith("0.")
    assert page.locator("td.force_n").nth(3).inner_text() == "--"
    page.wait_for_selector("#identification-title:has-text(' old')")
    grey = page.evaluate("getComputedStyle(document.querySelector('tbody .stale')).color")
    for value in ("#object", "#against", "#decision", "#decision-more", "#properties dd"):
        assert page.evaluate(f"getComputedStyle(document.querySelector('{value}')).color") == grey, value
    stage.scenario.age_s = 1.2
    page.wait_for_selector("tbody:nth-of-type(1) td:nth-of-type(3):has-text('--')")


def test_a_reload_in_mid_session_shows_it_again_with_its_last_ten_seconds(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    page.reload()
    page.wait_for_selector("body[data-shown=engaged]")
    page.keyboard.press("d")
    page.locator("#strip-table").evaluate("table => table.parentElement.focus()")
    page.wait_for_selector("#strip-table tr:nth-of-type(3) td:has-text('…')")
    low, high = (
        float(part) for part in page.inner_text("#strip-table tr:nth-of-type(3) td:nth-of-type(1)").split(" … ")
    )
    assert (low, high) == pytest.approx((1.15, 3.05), abs=0.06)
    assert page.inner_text("#pseudonym") == "P-0417"


def test_two_tabs_show_the_same_and_each_has_its_own_credit(stage: Stage, open_page: Open) -> None:
    first, second = open_page("engaged"), open_page()
    until(lambda: len(stage.clients) == 2)
    first.keyboard.press("p")
    for page in (first, second):
        page.wait_for_selector("body[data-shown=paused]")
    drawn = [client.drawn for client in stage.clients]
    until(lambda: all(client.drawn > before + 10 for client, before in zip(stage.clients, drawn, strict=True)))


def test_a_hidden_page_takes_two_pictures_and_is_live_again_at_once(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged", script=HIDEABLE)
    client = only(stage)
    until(lambda: client.drawn > 0)
    page.evaluate("hide(true)")
    # It reports its last drawn picture before it reports that it is hidden.
    until(lambda: client.alive and client.alive[-1]["visible"] is False and client.sent - client.drawn == CREDIT)
    skipped, drawn = client.skipped, client.drawn
    until(lambda: client.skipped > skipped + 60 and client.alive[-1]["visible"] is False)
    assert client.drawn == drawn
    assert client.most_under_way == CREDIT
    assert page.get_attribute("#alarm", "data-priority") == "none"
    woken = time.monotonic()
    page.evaluate("hide(false)")
    until(lambda: client.drawn > drawn + CREDIT)
    assert time.monotonic() - woken < 1.0
    assert stage.connections == 1


def test_a_frozen_page_whose_connection_was_closed_is_back_within_a_second_of_waking(
    stage: Stage, open_page: Open
) -> None:
    page = open_page("engaged")
    client = only(stage)
    until(lambda: client.drawn > 0)
    page.evaluate(
        """setTimeout(() => { const end = performance.now() + 2000;
          while (performance.now() < end); window.woken = Date.now(); })"""
    )
    skipped = client.skipped
    until(lambda: client.skipped > skipped + 30)
    assert client.most_under_way == CREDIT
    stage.close_all()
    until(lambda: stage.clients and stage.clients[-1] is not client and stage.clients[-1].drawn > 0)
    assert time.time() - page.evaluate("window.woken") / 1000 < 1.0
    page.wait_for_selector("body[data-shown=engaged]")


def test_it_says_once_a_second_that_it_is_alive_and_what_it_drew_last(stage: Stage, open_page: Open) -> None:
    open_page("engaged")
    client = only(stage)
    until(lambda: len(client.alive) >= 4)
    assert {message["visible"] for message in client.alive} == {True}
    assert client.alive[-1]["sequence"] > client.alive[1]["sequence"] > 0


def test_without_its_token_it_says_so_and_does_not_try_again(stage: Stage, open_page: Open) -> None:
    page = open_page("connected")
    stage.refuses = True
    stage.cut()
    page.wait_for_selector("#alarm-text:has-text('This address needs its token.')")
    stage.mend()
    connections = stage.connections
    page.wait_for_timeout(500)  # several times the first wait before trying again
    assert stage.connections == connections


DECODE = """async bytes => {
  const { decode, BadPicture } = await import('/page/picture.js');
  const buffer = Uint8Array.from(bytes).buffer;
  try {
    const p = decode(buffer);
    return p.kind === 2 ? ['tile', p.quantity, p.column, p.row] : ['picture', p.sequence, p.bins, p.of(1, 'force_n')];
  }
  catch (error) { return error instanceof BadPicture ? ['bad'] : ['thrown', String(error)]; }
}"""


def test_pictures_and_tiles_are_read_as_they_were_written(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    scenario = synthetic.engaged()
    for bins in (1, 7, 300):
        data = synthetic.picture(42, 2000, scenario, bins=bins)
        assert page.evaluate(DECODE, list(data)) == [
            "picture",
            42,
            bins,
            pytest.approx(synthetic.finger_row(1, 2000 * SPAN_S, scenario)[3]),
        ]
    assert page.evaluate(DECODE, list(synthetic.tile(2, 7, 1, 9))) == ["tile", 2, 7, 1]


def test_broken_frames_are_refused_as_bad_and_nothing_else(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged")
    chance = random.Random(7)
    picture, tile = synthetic.picture(42, 2000, synthetic.engaged()), synthetic.tile(0, 1, 1, 1)
    for number in range(150):
        data = bytearray(chance.choice((picture, tile)))
        if number % 3 == 0:
            del data[chance.randrange(len(data)) :]
        else:
            for _ in range(chance.randrange(1, 4)):
                data[chance.randrange(min(40, len(data)))] = chance.randrange(256)
        found = page.evaluate(DECODE, list(data))
        assert found[0] != "thrown", found
        if number % 3 == 0:
            assert found == ["bad"]


@pytest.mark.parametrize("offset", [0, 2, 3, 30, 31])
def test_a_wrong_head_is_a_bad_picture(open_page: Open, offset: int) -> None:
    page = open_page("engaged")
    data = bytearray(synthetic.picture(42, 2000, synthetic.engaged()))
    data[offset] ^= 0x55
    assert page.evaluate(DECODE, list(data)) == ["bad"]


SLOW_TIMERS = """
  const every = window.setInterval.bind(window);
  window.setInterval = (act, ms) => every(() => { if (!window.throttled) act(); }, ms);
  window.bursts = 0;
  const start = OscillatorNode.prototype.start;
  OscillatorNode.prototype.start = function (at_s) { window.bursts += 1; start.call(this, at_s); };
"""
"""A browser runs the timers of a page that is hidden for five minutes once a minute. Its messages still arrive."""


@pytest.mark.real_time(stall_s=math.inf)
def test_a_page_hidden_for_minutes_sounds_an_alarm_at_once_and_stays_awake(stage: Stage, open_page: Open) -> None:
    page = open_page("engaged", script=HIDEABLE + SLOW_TIMERS)
    page.click("#map-surface")  # a browser plays sound only after a person has used the page
    page.wait_for_function("() => import('/page/sound.js').then(sound => sound.soundPossible())")
    page.evaluate("window.hide(true); window.throttled = true")
    client = only(stage)
    heard = len(client.alive)
    stage.scenario.alarm("module-ring", "medium", "Ring module lost. Ring feels nothing.")
    until(lambda: page.evaluate("window.bursts") >= 3)
    until(lambda: len(client.alive) >= heard + 3)
