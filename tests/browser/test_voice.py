"""The voice on the page: heard and played, said by key and button, named in words at both ends."""

import math
import time
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from common.wire.voice_messages import BIT_S, FRAME_S
from tests.browser.conftest import SIZES, Open
from tests.browser.lossy_way import LossyWay
from tests.browser.stage import Stage
from tests.browser.test_every_state import LOOK, axe_findings
from tests.voice_sounds import coded_tone, decoded, loudest_hz
from tests.waiting import wait_until

pytest.importorskip("av", reason="the extra `voice` is not installed")
pytestmark = [pytest.mark.console, pytest.mark.timeout(120), pytest.mark.real_time(stall_s=math.inf)]

LISTEN = """
  const connect = AudioNode.prototype.connect, start = AudioBufferSourceNode.prototype.start;
  window.starts = [];
  AudioNode.prototype.connect = function (target, ...more) {
    if (this instanceof AudioBufferSourceNode) {
      if (!window.ear) { window.ear = this.context.createAnalyser(); window.ear.fftSize = 8192; }
      connect.call(this, window.ear);
    }
    return connect.call(this, target, ...more);
  };
  AudioBufferSourceNode.prototype.start = function (when) {
    window.starts.push([when, when - this.context.currentTime, this.playbackRate.value]);
    return start.call(this, when);
  };
"""
"""Lets a page count its sounds and listen to them."""
PITCH = """() => {
  if (!window.ear) return 0;
  const found = new Float32Array(window.ear.frequencyBinCount);
  window.ear.getFloatFrequencyData(found);
  const at = found.indexOf(Math.max(...found));
  return found[at] > -60 ? at * window.ear.context.sampleRate / window.ear.fftSize : 0;
}"""
"""Loudest frequency that the page plays, Hz; 0 for silence."""
REFUSED = "navigator.mediaDevices.getUserMedia = async () => {{ throw new DOMException('', '{}'); }};"
SAID = "#voice-said:has-text('{}')"


def listening(open_page: Open, scenario: str = "talking", script: str = "", **more: Any) -> Any:
    """A page whose user has clicked once, without which a browser plays nothing."""
    page = open_page(scenario, script=LISTEN + script, **more)
    page.mouse.click(3, 3)
    return page


def test_a_tone_is_heard_in_order_and_soon(stage: Stage, open_page: Open) -> None:
    stage.tone = coded_tone(440.0, 250)
    page = listening(open_page)
    page.wait_for_selector(SAID.format("Voice"))
    page.wait_for_function(f"() => Math.abs(({PITCH})() - 440) < 12")
    page.wait_for_function("() => window.starts.length > 100")
    starts = np.array(page.evaluate("() => window.starts"))
    assert (np.diff(starts[:, 0]) > 0.0).all()
    assert (starts[:, 1] <= 0.1601).all(), "no sound waits for more than 160 ms"
    assert set(starts[:, 2].round(3)) <= {1.0, 1.02}
    stage.tone = []
    page.wait_for_function(f"() => ({PITCH})() === 0")


def test_a_tone_is_heard_again_after_connections_were_lost_silently(
    stage: Stage, open_page: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage.tone = coded_tone(440.0, 250)
    with closing(LossyWay(stage.url)) as way:
        monkeypatch.setattr(Stage, "url", way.url)
        page = listening(open_page)
        page.wait_for_function(f"() => Math.abs(({PITCH})() - 440) < 12")
        way.lose()
        page.wait_for_function(f"() => ({PITCH})() === 0")
        page.wait_for_function(f"() => Math.abs(({PITCH})() - 440) < 12")


def test_old_sounds_are_not_played(stage: Stage, open_page: Open) -> None:
    stage.tone = coded_tone(440.0, 250)
    stage.tone_old_s = 0.6
    page = listening(open_page)
    page.wait_for_selector(SAID.format("Voice"))
    page.wait_for_timeout(500)
    assert page.evaluate("() => window.starts.length") == 0
    stage.tone_old_s = 0.0
    page.wait_for_function("() => window.starts.length > 10")


@pytest.mark.parametrize("way", ["key", "button"])
def test_while_it_is_held_the_microphone_is_heard(stage: Stage, open_page: Open, way: str) -> None:
    page = listening(open_page)
    page.wait_for_selector(SAID.format("you are muted"))
    hold, release = (
        (lambda: page.keyboard.down("h"), lambda: page.keyboard.up("h"))
        if way == "key"
        else (lambda: (page.hover("#talk"), page.mouse.down()), page.mouse.up)
    )
    hold()
    page.wait_for_selector(SAID.format("you are talking"))
    assert page.get_attribute("#talk", "aria-pressed") == "true"
    wait_until(lambda: len(stage.said) >= 100, lambda: len(stage.said), every_s=0.05)
    release()
    page.wait_for_selector(SAID.format("you are muted"))
    page.wait_for_timeout(200)
    count = len(stage.said)
    page.wait_for_timeout(400)
    assert len(stage.said) == count
    coded = [sound.content for sound in stage.said]
    assert {len(content) for content in coded} == {round(BIT_S * FRAME_S / 8)}, "a constant bit rate"
    assert [sound.sequence for sound in stage.said] == list(range(1, count + 1))
    samples = decoded(coded).astype(float)
    assert np.abs(samples).max() > 300, "the beep of the made-up microphone"
    began_s = np.array([sound.captured_s for sound in stage.said])
    assert np.median(np.diff(began_s)) == pytest.approx(FRAME_S, abs=0.002)
    assert time.monotonic() - began_s[-1] < 2.0
    assert max(sound.uncertainty_s for sound in stage.said[10:]) < 0.1
    loud = np.abs(samples) > 0.3 * np.abs(samples).max()
    first = max(0, int(np.argmax(loud)) - 200)
    print(f"beep at {loudest_hz(samples[first : first + 960].astype(np.int16)):.0f} Hz, {np.abs(samples).max():.0f}")


def test_talk_is_pressed_by_keyboard_alone(open_page: Open) -> None:
    page = listening(open_page)
    page.wait_for_selector(SAID.format("you are muted"))
    page.focus("#talk")
    page.keyboard.press("Enter")
    page.wait_for_selector(SAID.format("you are talking"))
    assert page.get_attribute("#talk", "aria-pressed") == "true"
    page.keyboard.press("Enter")
    page.wait_for_selector(SAID.format("you are muted"))


def test_an_open_microphone_is_heard_until_it_is_closed(stage: Stage, open_page: Open) -> None:
    page = listening(open_page)
    page.keyboard.press("o")
    page.wait_for_selector("#talk-open[aria-pressed=true]")
    wait_until(lambda: len(stage.said) >= 20, lambda: len(stage.said), every_s=0.05)
    page.click("#talk-open")
    page.wait_for_selector("#talk-open[aria-pressed=false]")
    page.wait_for_timeout(200)
    count = len(stage.said)
    page.wait_for_timeout(300)
    assert len(stage.said) == count


def test_talking_ends_with_control_and_begins_by_an_act_only(stage: Stage, open_page: Open) -> None:
    page = listening(open_page)
    page.keyboard.press("o")
    page.wait_for_selector(SAID.format("you are talking"))
    stage.scenario.state["you"] |= {"in_control": False, "control": "OR-2"}
    page.wait_for_selector("#talk-open[aria-pressed=false]:disabled")
    stage.scenario.state["you"] |= {"in_control": True, "control": "console"}
    page.wait_for_selector(SAID.format("you are muted"))


def test_who_hears_whom_is_said_in_words(stage: Stage, open_page: Open) -> None:
    page = listening(open_page)
    page.wait_for_selector(SAID.format("Voice · you are muted · recorded"))
    page.keyboard.press("o")
    page.wait_for_selector(SAID.format("you are talking"))
    voice = stage.scenario.state["voice"]
    voice["hears"] = False
    page.wait_for_selector(SAID.format("nobody hears you"))
    for heard, words in (
        ("muted", "Remote microphone muted"),
        ("no_microphone", "No remote microphone"),
        ("silent", "No voice"),
        ("refused", "Voice refuses the key"),
    ):
        voice["heard"] = heard
        page.wait_for_selector(SAID.format(words))
    stage.show("unheard")
    page.wait_for_selector(SAID.format("Remote microphone muted · OR-1 1 talks"))
    assert not page.is_visible("#talk")
    stage.show("engaged")
    page.wait_for_selector("#voice", state="hidden")


@pytest.mark.parametrize(
    ("script", "words"),
    [
        (REFUSED.format("NotAllowedError"), "microphone refused"),
        (REFUSED.format("NotFoundError"), "no microphone"),
        ("delete window.AudioDecoder;", "no voice here: HTTPS or localhost is needed"),
    ],
)
def test_a_page_without_a_microphone_says_why(open_page: Open, script: str, words: str) -> None:
    page = listening(open_page, script=script)
    page.keyboard.down("h")
    page.wait_for_selector(SAID.format(words))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("scenario", ["talking", "unheard"])
def test_it_fits_and_is_accessible(open_page: Open, picture_of: Any, scenario: str, size: str) -> None:
    page = open_page(scenario, SIZES[size])
    page.wait_for_selector("#voice-said:has-text('icrophone'), #voice-said:has-text('Voice')")
    page.wait_for_selector("#legend .scale canvas[aria-label]")  # the first picture was drawn
    picture_of(page, f"{scenario} {size}")
    assert page.evaluate(LOOK) + axe_findings(page) == []
