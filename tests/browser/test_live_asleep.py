"""A page that is hidden or frozen on a real console: nothing queues for it, and it is live again within a second."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from robustness.fault_session import read_figures
from tests.browser.conftest import chromium
from tests.browser.raw_chromium import Chromium, Tab, chromium_of
from tests.system.live_console import Session, running

pytestmark = [pytest.mark.console, pytest.mark.timeout(300)]

RECOVERED_S = 1.0
WATCHED_S = 2.5
ASLEEP_S = 3.5
"""The console sends nothing to a page that it did not hear for 3 s."""
PICTURE_BYTES = 750
"""At least; see `picture.py`."""
CONNECTED = "['connected', 'paused'].includes(document.body?.dataset.shown)"
PRESENT = "import('/page/now.js').then(({ now }) => { window.now = now; return now.picture !== null; })"


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    with running(tmp_path_factory.mktemp("asleep")) as session:
        yield session


@pytest.fixture(scope="module")
def browser_alone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    """A browser without automation."""
    path = chromium()
    if path is None:
        pytest.skip("no chromium: install it, or name it in CHROMIUM")
    with chromium_of(path, tmp_path_factory.mktemp("profile")) as browser:
        yield browser


@pytest.fixture
def tab(browser_alone: Chromium, session: Session) -> Iterator[Tab]:
    tab = browser_alone.tab(session.address)
    tab.until(CONNECTED)
    tab.until(PRESENT)
    yield tab
    tab.send("Page.close")


def queued_bytes(address: str) -> int:
    """What lies in the kernel's queues of all connections to a page's server."""
    port = f":{int(address.rpartition(':')[2]):04X}"
    lines = [line.split() for line in Path("/proc/net/tcp").read_text("ascii").splitlines()[1:]]
    queues = [line[4] for line in lines if line[1].endswith(port) or line[2].endswith(port)]
    return sum(int(part, 16) for queue in queues for part in queue.split(":"))


def watched_bytes(session: Session) -> list[int]:
    """What lay in the queues, looked at ten times a second."""
    lay, end_s = [], time.monotonic() + WATCHED_S
    while time.monotonic() < end_s:
        lay.append(queued_bytes(session.address))
        time.sleep(0.1)
    return lay


def skipped(session: Session) -> int:
    count: int = read_figures(session.folder, "console")["pictures_skipped"]
    return count


def drawn_since(tab: Tab, sequence: int) -> float:
    """When the page had drawn a newer picture and was live, s."""
    return tab.until(
        f"now.connected && now.picture.sequence > {sequence} && performance.now() - now.pictureAt_ms < 200"
    )


def test_pictures_for_a_hidden_page_are_skipped_and_it_is_live_again_at_once(
    browser_alone: Chromium, session: Session, tab: Tab
) -> None:
    browser_alone.tab("about:blank").to_front()
    tab.until("document.hidden")
    sequence, before = tab.evaluate("now.picture.sequence"), skipped(session)
    lay = watched_bytes(session)
    assert tab.evaluate("now.picture.sequence") == sequence, "a hidden page draws nothing"
    assert skipped(session) > before + 20
    # Thirty pictures a second would have been twice as much already.
    assert max(lay) < 0.5 * WATCHED_S * 30 * PICTURE_BYTES
    shown_s = time.monotonic()
    tab.to_front()
    assert drawn_since(tab, sequence) - shown_s < RECOVERED_S


def test_for_a_frozen_page_nothing_queues_and_it_is_back_within_a_second(
    browser_alone: Chromium, session: Session, tab: Tab
) -> None:
    browser_alone.tab("about:blank").to_front()
    tab.until("document.hidden")
    sequence = tab.evaluate("now.picture.sequence")
    tab.send("Page.setWebLifecycleState", state="frozen")
    time.sleep(ASLEEP_S)
    lay = watched_bytes(session)
    assert max(lay) < PICTURE_BYTES, "nothing is sent to a page that sleeps, but whether it is there"
    woken_s = time.monotonic()
    tab.send("Page.setWebLifecycleState", state="active")
    tab.to_front()
    assert drawn_since(tab, sequence) - woken_s < RECOVERED_S


def test_a_session_whose_page_is_hidden_pauses_and_says_why(
    browser_alone: Chromium, session: Session, tab: Tab
) -> None:
    tab.until("document.querySelector('#sound-refused:enabled') !== null")  # nothing is offered before data are live
    tab.evaluate("document.querySelector('#sound-refused').click()")
    tab.evaluate("document.querySelector('#begin-pseudonym').value = 'P-0420'")
    tab.evaluate("document.querySelector('#begin-form').requestSubmit()")
    tab.until("now.state.session.pseudonym === 'P-0420'")
    tab.until("document.querySelector('#act-button:enabled')?.textContent.startsWith('Engage')")
    tab.key("e", down=True)
    tab.until("document.body.dataset.shown === 'engaged'")
    tab.key("e", down=False)
    browser_alone.tab("about:blank").to_front()
    tab.until("now.state.session.state === 'paused'")
    tab.to_front()
    tab.until("document.querySelector('#alarm-text').textContent === 'PAUSED. Console was hidden for 3 s.'")
