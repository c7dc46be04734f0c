"""The patient's page in a real browser, read by the remote site's driver: stop, slider, silence, and its looks."""

import math
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from tests.browser.axe import violations

from common.config.models import PatientPageConfig
from common.limits import SWITCH_HOLD_S, SWITCH_LOST_S, SWITCH_SILENCE_S
from remote_site.devices.patient_switch import PatientSwitch
from remote_site.patient_page.run import run_patient_page
from tests.conftest import free_ports
from tests.waiting import wait_until

pytestmark = [pytest.mark.console, pytest.mark.timeout(120), pytest.mark.real_time(stall_s=math.inf)]

SIZES = [(360, 740), (800, 1280), (1024, 768), (1440, 900)]
READY = "Ready. You can stop at any time."


class Bedside:
    """The page's process in a thread, with the driver of the remote site at its line."""

    def __init__(self) -> None:
        ports, self._ended = free_ports(), threading.Event()
        config = PatientPageConfig(port=ports, switch_port=ports + 1)
        self.address = f"http://127.0.0.1:{config.port}/"
        self._thread = threading.Thread(target=run_patient_page, args=(config, self._ended.is_set))
        self._thread.start()
        self.driver = PatientSwitch(f"socket://127.0.0.1:{config.switch_port}")

    def age_s(self) -> float:
        now_s = time.monotonic()
        self.driver.read(now_s)
        return self.driver.reading(now_s).age_s

    def until(self, page: Any, reached: Callable[[], object]) -> float:
        """Read the driver until it is as wanted, while the browser works; return how long it took, s."""
        begun_s = time.monotonic()

        def looked() -> object:
            page.wait_for_timeout(2)
            self.age_s()
            return reached()

        wait_until(looked)
        return time.monotonic() - begun_s

    def close(self) -> None:
        self.driver.line.close()
        self._ended.set()
        self._thread.join()


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
    bedside.until(page, lambda: bedside.age_s() < SWITCH_SILENCE_S)
    page.get_by_role("status").get_by_text(READY).wait_for()
    yield page
    context.close()


def _opened(page: Any, address: str) -> bool:
    try:
        page.goto(address)
    except Exception:  # the server is not there yet
        return False
    return True


@pytest.mark.parametrize("way", ["touch", "mouse", "key"])
def test_a_press_reaches_the_driver_and_is_held(bedside: Bedside, page: Any, way: str) -> None:
    button = page.get_by_role("button", name="STOP")
    assert not bedside.driver.pressed
    begun_s = time.monotonic()
    {"touch": button.tap, "mouse": button.click, "key": lambda: page.keyboard.press("Escape")}[way]()
    bedside.until(page, lambda: bedside.driver.pressed)
    print(f"{way}: {(time.monotonic() - begun_s) * 1e3:.0f} ms from the act to the driver")
    page.get_by_role("status").get_by_text("Stopped. Say when it may continue.").wait_for()
    bedside.until(page, lambda: not bedside.driver.pressed)
    assert time.monotonic() - begun_s >= SWITCH_HOLD_S
    page.get_by_role("status").get_by_text(READY).wait_for()


def test_the_slider_is_the_pain_answer(bedside: Bedside, page: Any) -> None:
    slider = page.get_by_role("slider", name="How much does it hurt?")
    slider.fill("7")
    bedside.until(page, lambda: bedside.driver.pain == 7.0)
    slider.press("ArrowLeft")
    bedside.until(page, lambda: bedside.driver.pain == 6.0)
    assert not bedside.driver.pressed


def test_a_page_that_is_cut_off_or_closed_is_silent(bedside: Bedside, page: Any) -> None:
    page.evaluate("() => { const until = performance.now() + 900; while (performance.now() < until); }")
    assert bedside.age_s() > SWITCH_LOST_S, "a page that hangs"
    bedside.until(page, lambda: bedside.age_s() < SWITCH_SILENCE_S)
    page.goto("about:blank")
    bedside.until(page, lambda: bedside.age_s() > SWITCH_LOST_S)
    page.goto(bedside.address)
    bedside.until(page, lambda: bedside.age_s() < SWITCH_SILENCE_S)


def test_a_page_without_its_process_says_so(bedside: Bedside, page: Any) -> None:
    bedside.close()
    page.get_by_role("status").get_by_text("Not connected. The examination cannot continue.").wait_for()


def test_another_tablet_stops_too(bedside: Bedside, page: Any, browser: Any) -> None:
    context = browser.new_context()
    other = context.new_page()
    other.goto(bedside.address)
    other.get_by_role("status").get_by_text("Another tablet is in use. STOP works here too.").wait_for()
    other.get_by_role("button", name="STOP").click()
    bedside.until(page, lambda: bedside.driver.pressed)
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
    assert violations(page) == []
    picture_of(page, f"patient page {size[0]} x {size[1]}")
