"""A page on a real console, used as a person would use it, from whatever state the session is in."""

import re
import time
from typing import Any

from tests.browser.conftest import LIVE
from tests.system.live_console import Session
from tests.system.page import PATIENCE_S
from tests.system.truth import written

NEUTRAL = "body:is([data-shown=connected], [data-shown=paused])"
FORCE = """() => [...document.querySelectorAll('td.force_n')].some(cell => parseFloat(cell.textContent) > 0.2)"""


def opened(browser: Any, address: str, path: str = "/", theme: str = "dark", patience_ms: float = 20_000.0) -> Any:
    """A page in a window of its own, which has heard of the console's state."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme=theme)
    page.set_default_timeout(patience_ms)
    page.goto(address + path)
    page.wait_for_selector(LIVE)
    page.evaluate("import('/page/now.js').then(module => { window.now = module.now; })")
    page.wait_for_function("() => now.connected && now.picture !== null")
    return page


def state_of(page: Any) -> dict[str, Any]:
    """The newest state of the page."""
    state: dict[str, Any] = page.evaluate("now.state")
    return state


def hold(page: Any, key: str, until: str) -> None:
    """Hold a key until that is seen which it does."""
    page.keyboard.down(key)
    page.wait_for_selector(until)
    page.keyboard.up(key)


def begin(page: Any, study_number: str) -> None:
    """Begin an examination; one that is open is ended."""
    clear(page)
    if state_of(page)["session"]["pseudonym"] is not None:
        end(page)
    page.wait_for_selector("#begin-form:visible")  # it is offered where no examination is open
    if state_of(page)["session"]["sound"] is None:
        page.click("#sound-refused")
    if page.is_visible("#begin-consent"):
        page.check("#begin-consent")
    page.fill("#begin-pseudonym", study_number)
    page.keyboard.press("Enter")
    page.wait_for_selector(f"#pseudonym:has-text('{study_number}')")


def end(page: Any) -> None:
    """End the examination that is open."""
    page.click("#session-button")
    page.click("#end-button")
    page.click("#end-button:has-text('?')")


def clear(page: Any) -> None:
    """Come to a state in which nothing is driven and nothing is latched."""
    page.wait_for_selector("body:not([data-shown=stopping])")
    shown = page.get_attribute("body", "data-shown")
    if shown in ("engaged", "engaging"):
        page.keyboard.press("p")
    elif shown in ("fault", "stopped"):
        hold(page, "c", NEUTRAL)
    page.wait_for_selector(NEUTRAL)
    while page.locator("#act-button:has-text('Clear')").count():  # a busy machine lets data be late now and then
        hold(page, "c", "#act-button:not(:has-text('Clear'))")


def engage(page: Any) -> None:
    """Come to a state in which a finger feels a force, in an examination."""
    if state_of(page)["session"]["pseudonym"] is None:
        begin(page, "P-0400")
    clear(page)
    page.wait_for_selector("#act-button:enabled:is(:has-text('Engage'), :has-text('Resume'))")
    hold(page, "e", "body[data-shown=engaged]")
    page.wait_for_function(FORCE)


def aim(page: Any, x_mm: float, y_mm: float) -> None:
    """Move the crosshair of a finding to a place, by arrow keys."""
    found = re.search(r"x (-?\d+) y (-?\d+) mm", page.inner_text("#marking-title"))
    assert found
    x, y = round(x_mm) - int(found[1]), round(y_mm) - int(found[2])
    for key, count in (("ArrowRight", x), ("ArrowLeft", -x), ("ArrowUp", y), ("ArrowDown", -y)):
        for _ in range(count):
            page.keyboard.press(key)


def at_devices(session: Session, stream: str, from_s: float, to_s: float) -> list[dict[str, Any]]:
    """What a simulated device really did in from_s..to_s, once it has written all of it down."""
    end_s = time.monotonic() + PATIENCE_S
    while True:
        found = written(session.folder / "sim-operator.mcap", stream, from_s, may_be_cut=True)
        if found and found[-1][0] >= to_s:
            return [entry for at_s, entry in found if at_s < to_s]
        assert time.monotonic() < end_s, f"{stream} is not written up to {to_s} s"
        time.sleep(0.05)
