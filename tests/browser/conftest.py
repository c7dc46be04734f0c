"""A real Chromium, driven by playwright; where one of them is missing, the tests of the page skip with the reason."""

import os
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.browser.stage import Stage

SIZES = {
    "1440 x 900": (1440, 900, 1),
    "1024 x 768": (1024, 768, 1),
    "1024 x 720": (1024, 720, 1),
    "768 x 1024": (768, 1024, 1),
    "800 x 1280": (800, 1280, 1),
    "360 x 740": (360, 740, 1),
    "1440 x 900 at 200 %": (720, 450, 2),
    "1024 x 768 at 200 %": (512, 384, 2),
}
"""Width and height in CSS pixels, and the pixel ratio: a zoom of 200 % halves the first two and doubles the last."""
FAKE_MICROPHONE = ("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream")
"""A microphone that beeps once a second, and a user who allows it."""
USED = "--autoplay-policy=no-user-gesture-required"
"""The user has pressed something before: the page may sound."""
LIVE = "body[data-shown]:not([data-shown=unknown])"
"""The page has heard of the console's state."""
THROTTLING_OFF = (
    "--disable-background-timer-throttling",
    "--disable-backgrounding-occluded-windows",
    "--disable-renderer-backgrounding",
)


def chromium() -> str | None:
    """The browser: $CHROMIUM, or the system's."""
    return os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """One browser for all tests; a hidden page is really hidden in it."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (group browser)")
    path = chromium()
    if path is None:
        pytest.skip("no chromium: install it, or name it in CHROMIUM")
    with sync_api.sync_playwright() as playwright:
        opened = playwright.chromium.launch(
            executable_path=path,
            args=["--no-sandbox", USED, *FAKE_MICROPHONE],
            ignore_default_args=list(THROTTLING_OFF),
        )
        yield opened
        opened.close()


@pytest.fixture
def stage() -> Iterator[Stage]:
    """A console with made-up data."""
    with Stage() as running:
        yield running


Open = Callable[..., Any]


@pytest.fixture
def open_page(browser: Any, stage: Stage) -> Iterator[Open]:
    """Opens the page on the stage; at the end no page may have met an error or broken its content-security policy."""
    contexts: list[Any] = []
    wrong: list[str] = []

    def heard(message: Any) -> None:
        # With a new title of the tab the browser asks for its icon again, also while the console is away.
        icon = message.location["url"].endswith("/icon.svg")
        if message.type == "error" and "WebSocket connection to" not in message.text and not icon:
            wrong.append(message.text)

    def opener(
        scenario: str | None = None,
        size: tuple[int, int, int] = (1440, 900, 1),
        theme: str = "dark",
        script: str = "",
        **more: Any,
    ) -> Any:
        if scenario:
            stage.show(scenario)
        context = browser.new_context(
            viewport={"width": size[0], "height": size[1]}, device_scale_factor=size[2], color_scheme=theme, **more
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(10_000)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("console", heard)
        if script:
            page.add_init_script(script)
        page.goto(stage.url)
        page.wait_for_selector(LIVE)
        return page

    yield opener
    for context in contexts:
        context.close()
    assert wrong == []


@pytest.fixture
def picture_of() -> Callable[[Any, str], None]:
    """Keeps a screenshot in $SCREENSHOTS, where that is named."""
    folder = os.environ.get("SCREENSHOTS")

    def keep(page: Any, name: str) -> None:
        if folder:
            Path(folder).mkdir(parents=True, exist_ok=True)
            page.screenshot(path=str(Path(folder) / f"{name.replace(' ', '_').replace('%', '')}.png"))

    return keep


def wait_for(stage: Stage, verb: str, count: int = 1) -> list[dict[str, Any]]:
    """The requests of a verb once there are `count`; polls the stage, which runs in another thread."""
    until = time.monotonic() + 10
    while time.monotonic() < until:
        found = [ask for ask in stage.asks if ask["verb"] == verb]
        if len(found) >= count:
            return found
        time.sleep(0.005)
    raise AssertionError(f"{verb} was asked {len(found)} times, not {count}")
