"""`python -m tests.browser.readme_picture FILE`: the console while a demo explores the phantom, in a real Chromium."""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from playwright.sync_api import sync_playwright

from tests.browser.conftest import chromium
from tests.browser.live import aim, begin, engage, opened
from tests.browser.running_demo import running
from tests.browser.test_live_demo import lesion_mm

STROKES_S = 40.0
"""All of the surface is stroked by then, twenty lines 5 mm apart; what comes next are presses."""


def main(path: Path) -> None:
    """Begin an examination, let the hand stroke and press, mark a finding, and keep what the page shows."""
    with (
        TemporaryDirectory() as folder,
        running(Path(folder) / "out", "--scene", "phantom_sweep", "--seed", "3") as demo,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        page = opened(browser, demo.address)
        page.click("#sound-play")
        page.click("#sound-heard")
        begin(page, "P-0417")
        engage(page)
        page.keyboard.press("r")
        page.wait_for_function(f"() => now.state.session.clock_s > {STROKES_S}", timeout=120_000)
        page.keyboard.press("f")
        page.keyboard.press("1")
        aim(page, *lesion_mm())
        page.keyboard.press("Enter")
        page.wait_for_selector("#marking", state="hidden")
        page.wait_for_function("() => now.state.fingers.every(finger => (finger.contact_s ?? 0) > 0.3)", timeout=20_000)
        page.screenshot(path=str(path))
        browser.close()
        demo.finish()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
