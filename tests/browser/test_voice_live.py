"""A voice's process over real Curve, a console without an operator site, and its page: mouth to ear, both ways."""

import math
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest

from common.config.page_models import ConsoleVoiceConfig
from common.config.recording_models import ConsentConfig
from common.recording.reader import RecordingReader
from common.recording.recorder import Recorder
from operator_site.console.examination.journal import SCHEMAS as KEPT
from operator_site.console.voice.voice_sound import VoiceSound
from operator_site.site_recording import SCHEMAS
from tests.browser.conftest import LIVE
from tests.browser.running_console import RunningConsole
from tests.browser.test_camera_live import _served
from tests.browser.test_voice import LISTEN, PITCH, SAID
from tests.conftest import Keys
from tests.system.played_console import playing
from tests.unit.operator_site.console.fed import S, figures, rendered, touch
from tests.unit.operator_site.console.voice.fake_voice import FakeVoice, until
from tests.voice_sounds import coded_tone, decoded

pytest.importorskip("av", reason="the extra `voice` is not installed")
pytestmark = [pytest.mark.console, pytest.mark.timeout(120), pytest.mark.real_time(stall_s=math.inf)]

AGES = """async () => {
  const { siteTime_s } = await import('/page/camera.js');
  const decode = AudioDecoder.prototype.decode, start = AudioBufferSourceNode.prototype.start;
  const encode = AudioEncoder.prototype.encode, close = AudioData.prototype.close, under_way = [], own = new WeakSet();
  window.ages = [];
  AudioDecoder.prototype.decode = function (chunk) {
    under_way.push(chunk.timestamp / 1e6);
    return decode.call(this, chunk);
  };
  AudioEncoder.prototype.encode = function (data) { own.add(data); return encode.call(this, data); };
  AudioBufferSourceNode.prototype.start = function (when) {
    const { currentTime, outputLatency } = this.context;
    if (under_way.length) window.ages.push([siteTime_s() - under_way[0] + when - currentTime, outputLatency]);
    return start.call(this, when);
  };
  AudioData.prototype.close = function () { if (!own.has(this)) under_way.shift(); return close.call(this); };
}"""
"""Notes the age of each sound at the moment for which it is scheduled, s, and the browser's output latency, s."""


class Talking:
    """A voice's process in a thread, which says a tone."""

    def __init__(self, base_port: int, keys: Keys) -> None:
        self.voice = FakeVoice(base_port, keys)
        self.voice.consents = True
        self._on = True
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        coded, number, due_s = coded_tone(440.0, 500), 0, time.monotonic()
        while self._on:
            self.voice.turn()
            if (now_s := time.monotonic()) >= due_s:
                due_s = max(due_s + 0.02, now_s - 0.1)
                number += 1
                self.voice.say(coded[number % len(coded)])
            time.sleep(0.002)

    def close(self) -> None:
        """End the process."""
        self._on = False
        self._thread.join()
        self.voice.close()


@pytest.fixture
def record(tmp_path: Path) -> Path:
    return tmp_path / "console.mcap"


@pytest.fixture
def console(base_port: int, keys: Keys, record: Path) -> Iterator[RunningConsole]:
    made = RunningConsole(
        keys,
        record,
        voice=ConsoleVoiceConfig(base_port=base_port, record=True),
        consent=ConsentConfig(touch=True, pain=True, voice=True),
    )
    yield made
    made.end()


@pytest.fixture
def talking(base_port: int, keys: Keys) -> Iterator[Talking]:
    made = Talking(base_port, keys)
    yield made
    made.close()


def test_both_ends_hear_each_other_and_both_are_recorded(
    browser: Any, console: RunningConsole, talking: Talking, record: Path
) -> None:
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.add_init_script(LISTEN)
    until(lambda: _served(page, console.address))
    page.wait_for_selector("#sheet-session:visible")
    page.keyboard.press("Escape")
    page.mouse.click(3, 3)
    page.wait_for_selector(SAID.format("Voice · you are muted · recorded"))
    page.wait_for_function(f"() => Math.abs(({PITCH})() - 440) < 12")
    page.evaluate(AGES)
    page.keyboard.down("h")
    page.wait_for_selector(SAID.format("you are talking"))
    talking.voice.ages_s.clear()
    page.wait_for_function("() => window.ages.length > 400", timeout=30_000)
    page.keyboard.up("h")
    to_ear_s, latency_s = np.array(page.evaluate("() => window.ages")).T
    to_remote_s = np.array(talking.voice.ages_s)
    page.close()
    console.end()
    ways = {"remote mouth to the page's ear": to_ear_s, "the page's mouth to the remote site": to_remote_s}
    for way, ages_s in ways.items():
        middle_ms, late_ms = 1e3 * np.quantile(ages_s, (0.5, 0.99))
        print(f"{way}: {middle_ms:.0f} ms, 99 % {late_ms:.0f} ms, {len(ages_s)} sounds")
    print(f"the browser's output latency: {1e3 * np.median(latency_s):.0f} ms")
    assert np.median(to_ear_s) < 0.3
    assert np.median(to_remote_s) < 0.3
    assert np.abs(decoded([sound.content for sound in talking.voice.sounds]).astype(float)).max() > 300
    with record.open("rb") as file:
        messages = RecordingReader(record, file).messages(["console/voice"])
        kept = [VoiceSound.of_record(one.data) for _, _, one in messages]
    assert {sound.direction for sound in kept} == {"from_remote", "to_remote"}
    assert np.median([sound.uncertainty_s for sound in kept]) < 0.05


def test_a_recorded_voice_is_played(browser: Any, tmp_path: Path) -> None:
    start_ns, seconds, path = 100 * S, 8, tmp_path / "session.mcap"
    with Recorder(path, SCHEMAS | KEPT, {}) as recorder:
        for tick in range(seconds * 100):
            at_ns = start_ns + tick * S // 100
            recorder.write("operator/touch", at_ns, touch(tick, at_ns - 20_000_000))
            recorder.write("operator/rendered", at_ns, rendered())
            if tick % 100 == 0:
                recorder.write("operator/figures", at_ns, figures())
        for number, content in enumerate(coded_tone(440.0, seconds * 50)):
            at_ns = start_ns + number * S // 50
            sound = VoiceSound("from_remote", number, (at_ns - 50_000_000) * 1e-9, 0.001, content)
            recorder.write("console/voice", at_ns, msgpack.packb(sound.record()))
    with playing(path) as address:
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.add_init_script(LISTEN)
        page.goto(address)
        page.wait_for_selector(LIVE)
        page.mouse.click(3, 3)
        page.wait_for_selector(SAID.format("Voice · recorded"))
        assert not page.is_visible("#talk")
        page.keyboard.press(" ")
        page.wait_for_function(f"() => Math.abs(({PITCH})() - 440) < 12")
        page.keyboard.press(" ")
        page.wait_for_function(f"() => ({PITCH})() === 0")
        page.close()
