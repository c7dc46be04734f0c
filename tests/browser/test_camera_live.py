"""A camera's process over real Curve, a console without an operator site, and its page in a real browser."""

import math
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from common.config.page_models import ConsoleCameraConfig
from common.config.recording_models import ConsentConfig
from common.recording.reader import RecordingReader
from operator_site.console.camera.camera_picture import Picture
from tests.browser.conftest import LIVE
from tests.browser.running_console import RunningConsole
from tests.browser.test_camera import LIVE_TEXT, NAMED, NAMED_MS
from tests.conftest import Keys
from tests.unit.operator_site.console.camera.fake_camera import FakeCamera, until
from tests.vp8_stream import HZ, pictures

pytestmark = [pytest.mark.console, pytest.mark.timeout(120), pytest.mark.real_time(stall_s=math.inf)]


class Filming:
    """A camera's process in a thread, which shows the test stream."""

    def __init__(self, base_port: int, keys: Keys) -> None:
        self.films, self._on = True, True
        self._camera = FakeCamera(base_port, keys)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        coded, number, due_s = pictures(), 0, time.monotonic()
        while self._on:
            self._camera.hear()
            if self.films and self._camera.asks and time.monotonic() >= due_s:
                is_key, content = coded[number % len(coded)]
                number += 1
                due_s = time.monotonic() + 1.0 / HZ
                self._camera.send(number, content, is_key=is_key)
            time.sleep(0.002)

    def close(self) -> None:
        """End the process."""
        self._on = False
        self._thread.join()
        self._camera.close()


@pytest.fixture
def record(tmp_path: Path) -> Path:
    return tmp_path / "console.mcap"


@pytest.fixture
def console(base_port: int, keys: Keys, record: Path) -> Iterator[RunningConsole]:
    made = RunningConsole(
        keys,
        record,
        consent=ConsentConfig(touch=True, pain=False, picture=True),
        camera=ConsoleCameraConfig(base_port=base_port, required=True, record=True),
    )
    yield made
    made.end()


@pytest.fixture
def filming(base_port: int, keys: Keys) -> Iterator[Filming]:
    made = Filming(base_port, keys)
    yield made
    made.close()


def test_a_picture_comes_through_to_the_page_and_into_the_record(
    browser: Any, console: RunningConsole, filming: Filming, record: Path
) -> None:
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    until(lambda: _served(page, console.address))
    page.wait_for_selector("#sheet-session:visible")
    page.keyboard.press("Escape")
    page.wait_for_selector(LIVE_TEXT)
    page.evaluate(f"() => {{ window.named = ({NAMED})(); }}")
    page.wait_for_timeout(1000)
    filming.films = False
    named_ms, marked, text = page.evaluate("() => window.named")
    assert marked
    assert text.startswith("Picture frozen for 0.")
    assert named_ms <= NAMED_MS
    page.wait_for_selector("#alarm-text:has-text('Session pauses.')")
    print(f"frozen picture named {named_ms:.0f} ms after the last drawn one")
    filming.films = True
    page.wait_for_selector(LIVE_TEXT)
    page.wait_for_selector("#alarm-text:not(:has-text('Session pauses.'))")
    page.close()
    console.end()
    with record.open("rb") as file:
        kept = [Picture.of_record(one.data) for _, _, one in RecordingReader(record, file).messages(["console/camera"])]
    first = kept[0].sequence  # those before it came before the remote site's consent was known
    assert [one.sequence for one in kept] == [*range(first, first + len(kept))]
    assert first <= HZ
    assert kept[-1].sequence > HZ
    assert max(one.uncertainty_s for one in kept[HZ:]) < 0.005
    print(f"{len(kept)} pictures, capture times within {1e6 * kept[-1].uncertainty_s:.0f} us")


def _served(page: Any, address: str) -> bool:
    """Whether the console serves its page."""
    try:
        page.goto(address)
    except Exception:  # playwright's own error
        return False
    page.wait_for_selector(LIVE)
    return True
