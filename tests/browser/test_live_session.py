"""The page in a real browser on a real console: an operator site on a virtual environment with simulated devices.

One session serves all these tests; each of them brings it from whatever state it is in to the one that it needs.
"""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from operator_site.console.examination.reporting import LONGEST_S
from operator_site.console.texts import CONSOLE_NOT_RECORDED
from robustness.fault_session import let_write
from tests.browser.live import at_devices, begin, clear, engage, opened
from tests.browser.test_every_state import LOOK, axe_findings
from tests.browser.test_page import HOSTILE, LONGEST
from tests.system.live_console import Session, running
from tests.system.truth import written

pytestmark = [pytest.mark.console, pytest.mark.timeout(300)]

DEVICES = 3
"""Two fingers' modules and the exoskeleton."""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    with running(tmp_path_factory.mktemp("live")) as session:
        yield session


@pytest.fixture
def page(browser: Any, session: Session) -> Iterator[Any]:
    """A page on the session, which must meet no error."""
    page = opened(browser, session.address)
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    yield page
    page.close()
    assert wrong == []


def mark(page: Any, kind: str) -> int:
    """Mark a finding where the active finger is, with its kind's key; its number."""
    page.keyboard.press("f")
    page.keyboard.press(kind)
    page.keyboard.press("Enter")
    page.wait_for_selector("#marking", state="hidden")
    found = re.match(r"Finding (\d+) ", page.inner_text("#read-out"))
    assert found, page.inner_text("#read-out")
    return int(found[1])


def test_a_whole_session_from_its_beginning_to_its_report(page: Any, picture_of: Callable[[Any, str], None]) -> None:
    clear(page)
    picture_of(page, "live connected")
    begin(page, "P-0417")
    engage(page)
    picture_of(page, "live engaged")
    assert page.evaluate(LOOK) + axe_findings(page) == []
    mark(page, "1")
    page.wait_for_function("() => now.state.findings.length === 1")
    page.keyboard.press("n")
    note = (HOSTILE * LONGEST)[:LONGEST]
    page.fill("#note-text", note)
    page.click("#noting [type=submit]")
    page.wait_for_selector("#read-out:has-text('Note to finding 1 ')")
    page.keyboard.press("p")
    page.wait_for_selector("body[data-shown=paused]")
    picture_of(page, "live paused")

    page.click("#session-button")
    page.wait_for_selector("#findings-list li", state="attached")
    page.click("#end-button")
    page.click("#end-button:has-text('End examination P-0417? 1 finding.')")
    page.wait_for_selector("#report-link:visible", timeout=LONGEST_S * 1000)
    picture_of(page, "live ended")
    with page.context.expect_page() as opening:
        page.click("#report-link")
    report = opening.value
    report.wait_for_load_state()
    text = report.locator("body").inner_text()
    assert "P-0417" in text
    kept = "".join(note.split())  # white space is laid out again
    assert kept in "".join(text.split()), "the note is in the report as it was written"
    assert report.evaluate("window.struck") is None
    assert page.evaluate("window.struck") is None


@pytest.mark.parametrize("by", ["click", "key"])
def test_a_stop_is_confirmed_by_each_device_and_seen_at_them(
    page: Any, session: Session, picture_of: Callable[[Any, str], None], by: str
) -> None:
    engage(page)
    pressed_s = time.monotonic()
    if by == "click":
        page.click("#stop")
    else:
        page.keyboard.press("Space")
    page.wait_for_selector(f"#answers-title:has-text('STOPPED. All {DEVICES} devices confirmed in 0.')")
    stopped_s = time.monotonic()
    assert page.locator("#answers-list li.stopped").count() == DEVICES
    page.wait_for_selector("#state-word:text-is('STOPPED')")
    picture_of(page, "live stopped")
    before = at_devices(session, "truth_fingertips", pressed_s - 0.3, pressed_s)
    after = at_devices(session, "truth_fingertips", stopped_s, stopped_s + 0.5)
    assert max(force_n for entry in before for force_n in entry["force_n"]) > 0.1, "there was something to stop"
    assert max(force_n for entry in after for force_n in entry["force_n"]) == 0.0
    assert max(rpm for entry in after for rpm in entry["motor_rpm"]) < 100.0


@contextmanager
def full_disk(session: Session) -> Iterator[None]:
    """The console's process, and what it started, may write to no file."""
    pid = session.processes.running["console"].pid
    let_write(pid, allowed=False)
    try:
        yield
    finally:
        let_write(pid, allowed=True)


def kept(folder: Path, note: str) -> bool:
    """Whether a note is on the disk, in whichever file."""
    records = (r for path in folder.glob("console*.mcap") for _, r in written(path, "console/finding", may_be_cut=True))
    return any(record["note"] == note for record in records)


def test_what_a_full_disk_does_not_take_is_said_and_is_kept_when_there_is_room(page: Any, session: Session) -> None:
    begin(page, "P-0409")
    note = "felt while the disk was full"
    with full_disk(session):
        number = mark(page, "4")
        page.wait_for_function(f"() => now.state.findings.some(found => found.id === {number})")
        page.keyboard.press("n")
        page.fill("#note-text", note)
        page.click("#noting [type=submit]")
        page.wait_for_selector(f"#read-out:has-text('Note to finding {number} kept here, not yet on disk.')")
        page.wait_for_selector(f'#alarm-text:has-text("{CONSOLE_NOT_RECORDED}")')
        page.click("#session-button")
        page.wait_for_selector("#findings-list li:has-text('not yet on disk')")
    page.wait_for_selector("#findings-list li:not(:has-text('not yet on disk'))")
    assert kept(session.folder, note)
