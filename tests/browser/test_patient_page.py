"""The patient's page in a real browser, read by the remote site's driver: stop, slider, silence, and its looks."""

import io
import math
import threading
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import pytest
from matplotlib.image import imread

from common.config.page_models import PatientPageConfig
from common.limits import SWITCH_HOLD_S, SWITCH_LOST_S, SWITCH_SILENCE_S
from remote_site.devices.patient_switch import PatientSwitch
from remote_site.patient_page.run import run_patient_page
from tests.browser.test_every_state import LOOK, axe_findings
from tests.ports import free_ports
from tests.waiting import wait_until

pytestmark = [pytest.mark.console, pytest.mark.timeout(120), pytest.mark.real_time(stall_s=math.inf)]

SIZES = [(360, 740), (740, 360), (512, 384), (800, 1280), (1024, 768), (1440, 900)]
READY = "Ready. You can stop at any time."


class Bedside:
    """The page's process in a thread, and the remote site's driver at its line in another.

    Attributes:
        address: of the page.
        driver: the driver, which is read every 2 ms.
        pressed_ms: time of each press at the driver, ms of the browser's clock.
    """

    def __init__(self) -> None:
        ports, self._ended = free_ports(), threading.Event()
        config = PatientPageConfig(port=ports, switch_port=ports + 1)
        self.address = f"http://127.0.0.1:{config.port}/"
        self.driver = PatientSwitch(f"socket://127.0.0.1:{config.switch_port}")
        self.pressed_ms: list[float] = []
        self._server = threading.Thread(target=run_patient_page, args=(config, self._ended.is_set))
        self._site = threading.Thread(target=self._read)
        self._server.start()
        self._site.start()

    def _read(self) -> None:
        was = True  # before the first report
        while not self._ended.wait(0.002):
            self.driver.read(time.monotonic())
            if self.driver.pressed and not was:
                self.pressed_ms.append(time.time() * 1e3)
            was = self.driver.pressed
        self.driver.line.close()

    def age_s(self) -> float:
        return self.driver.reading(time.monotonic()).age_s

    def close(self) -> None:
        self._ended.set()
        self._server.join()
        self._site.join()


@pytest.fixture
def bedside() -> Iterator[Bedside]:
    bedside = Bedside()
    yield bedside
    bedside.close()


@pytest.fixture
def page(browser: Any, bedside: Bedside) -> Iterator[Any]:
    context = browser.new_context(viewport={"width": 800, "height": 1280}, has_touch=True)
    page = context.new_page()
    wait_until(lambda: _opened(page, bedside.address))
    wait_until(lambda: bedside.age_s() < SWITCH_SILENCE_S)
    page.get_by_role("status").get_by_text(READY).wait_for()
    yield page
    context.close()


def _opened(page: Any, address: str) -> bool:
    try:
        page.goto(address)
    except Exception:  # the server is not there yet
        return False
    return True


@pytest.mark.parametrize("way", ["touch", "mouse", "key", "assistive software"])
def test_a_press_reaches_the_driver_and_is_held(bedside: Bedside, page: Any, way: str) -> None:
    button = page.get_by_role("button", name="STOP")
    assert not bedside.driver.pressed
    begun_s = time.monotonic()
    page.evaluate("() => addEventListener('pointerdown', (event) => (window.act_ms = event.timeStamp), true)")
    page.evaluate("() => addEventListener('keydown', (event) => (window.act_ms = event.timeStamp), true)")
    page.evaluate("() => addEventListener('click', (event) => (window.act_ms ??= event.timeStamp), true)")
    {
        "touch": button.tap,
        "mouse": button.click,
        "key": lambda: page.keyboard.press("Escape"),
        "assistive software": lambda: button.evaluate("button => button.click()"),
    }[way]()
    wait_until(lambda: bedside.pressed_ms)
    taken_ms = bedside.pressed_ms[-1] - page.evaluate("() => performance.timeOrigin + window.act_ms")
    print(f"{way}: {taken_ms:.0f} ms from the act to the driver")
    page.get_by_role("status").get_by_text("Stopped. Say when it may continue.").wait_for()
    wait_until(lambda: not bedside.driver.pressed)
    assert time.monotonic() - begun_s >= SWITCH_HOLD_S


def test_the_slider_is_the_pain_answer(bedside: Bedside, page: Any) -> None:
    slider = page.get_by_role("slider", name="How much does it hurt?")
    slider.fill("7")
    wait_until(lambda: bedside.driver.pain == 7.0)
    slider.press("ArrowLeft")
    wait_until(lambda: bedside.driver.pain == 6.0)
    assert not bedside.driver.pressed


def test_a_reload_leaves_the_slider_where_the_patient_has_set_it(bedside: Bedside, page: Any) -> None:
    page.get_by_role("slider").fill("7")
    wait_until(lambda: bedside.driver.pain == 7.0)
    pains = []
    page.reload()
    for _ in range(100):
        pains.append(bedside.driver.pain)
        time.sleep(0.01)
    assert set(pains) == {7.0}
    assert page.get_by_role("slider").input_value() == "7"


def test_a_page_that_hangs_or_is_closed_is_silent(bedside: Bedside, page: Any) -> None:
    hang = "() => void setTimeout(() => { const until = performance.now() + 2000; while (performance.now() < until); })"
    page.evaluate(hang)
    wait_until(lambda: bedside.age_s() > SWITCH_LOST_S)
    wait_until(lambda: bedside.age_s() < SWITCH_SILENCE_S)
    page.goto("about:blank")
    wait_until(lambda: bedside.age_s() > SWITCH_LOST_S)
    page.goto(bedside.address)
    wait_until(lambda: bedside.age_s() < SWITCH_SILENCE_S)


def test_a_page_without_its_process_says_so(bedside: Bedside, page: Any) -> None:
    bedside.close()
    page.get_by_role("status").get_by_text("Not connected. The examination cannot continue.").wait_for()


SOCKETS = """window.sockets = [];
  window.WebSocket = class extends WebSocket {
    constructor(address) { super(address); sockets.push(this); }
    addEventListener(kind, act) { super.addEventListener(kind, event => { if (!this.deaf) act(event); }); }
  };"""


def test_a_page_whose_network_has_gone_connects_again(bedside: Bedside, page: Any) -> None:
    page.add_init_script(SOCKETS)
    page.reload()
    page.get_by_role("status").get_by_text(READY).wait_for()
    page.evaluate("() => { sockets[0].deaf = true; }")
    page.get_by_role("status").get_by_text("Not connected. The examination cannot continue.").wait_for()
    wait_until(lambda: bedside.age_s() > SWITCH_LOST_S)
    page.get_by_role("status").get_by_text(READY).wait_for()
    wait_until(lambda: bedside.age_s() < SWITCH_SILENCE_S)
    assert page.evaluate("() => sockets.map(socket => socket.readyState > WebSocket.OPEN)") == [True, False]


@pytest.mark.parametrize(
    ("code", "why"),
    [
        (4401, "This page may not be used here. Ask for its address again."),
        (4408, "Too many tablets are open. Close one."),
    ],
)
def test_a_refused_page_says_why_and_asks_less_and_less_often(page: Any, code: int, why: str) -> None:
    opened_s: list[float] = []

    def refuse(socket: Any) -> None:
        opened_s.append(time.monotonic())
        socket.close(code=code)

    page.route_web_socket("**/patient", refuse)
    page.reload()
    page.get_by_role("status").get_by_text(why).wait_for()
    page.wait_for_timeout(5500)
    waits_s = [later - before for before, later in pairwise(opened_s)]
    assert 2 <= len(waits_s) <= 3, "of 0.5, 1 and 2 s; 4 s are not over"
    assert waits_s[-1] > 2 * waits_s[0]
    page.get_by_role("status").get_by_text(why).wait_for()


def test_another_tablet_stops_too(bedside: Bedside, page: Any, browser: Any) -> None:
    page.get_by_role("slider").fill("4")
    context = browser.new_context()
    other = context.new_page()
    other.goto(bedside.address)
    other.get_by_role("status").get_by_text("Another tablet is in use. STOP works here too.").wait_for()
    assert other.get_by_role("slider").input_value() == "4"
    other.get_by_role("button", name="STOP").click()
    wait_until(lambda: bedside.driver.pressed)
    context.close()


@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[0]} x {size[1]}")
def test_all_of_it_is_seen_at_every_size(
    bedside: Bedside, page: Any, size: tuple[int, int], picture_of: Callable[[Any, str], None]
) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.get_by_role("status").get_by_text(READY).wait_for()
    for box in (each.bounding_box() for each in page.locator("h1, button, input").all()):
        assert box is not None
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= size[0]
        assert box["y"] + box["height"] <= size[1]
    assert page.evaluate(LOOK) + axe_findings(page) == []
    picture_of(page, f"patient page {size[0]} x {size[1]}")


def test_large_text_leaves_the_slider_in_view(page: Any) -> None:
    page.set_viewport_size({"width": 360, "height": 740})
    page.evaluate("document.documentElement.style.fontSize = '32px'")
    page.get_by_role("status").get_by_text(READY).wait_for()
    assert page.evaluate("document.documentElement.scrollHeight") == 740
    assert page.get_by_role("button", name="STOP").bounding_box()["height"] >= 0.3 * 740


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_with_the_systems_colours_button_and_slider_are_seen(page: Any, scheme: str) -> None:
    page.emulate_media(forced_colors="active", color_scheme=scheme)
    red = imread(io.BytesIO(page.locator("#stop").screenshot()))[200, 50]
    assert red[0] - red[1:3].max() > 0.4
    thumb, *_, beside = imread(io.BytesIO(page.locator("#slider").screenshot()))[48, 44:200]
    assert abs(thumb[:3] - beside[:3]).max() > 0.2
