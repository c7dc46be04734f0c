"""Sources and sinks: tones, files and devices. The device of the tests is ALSA's `null`, which every machine has."""

import itertools
import resource
import threading
import time
import wave
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import MagicMock, Mock

import av
import numpy as np
import pytest

from remote_site.voice.alsa import FOLDER
from remote_site.voice.opus_codec import Samples
from remote_site.voice.sound_sink import DeviceSink, NoSink, WavSink, open_sink
from remote_site.voice.sound_source import LOUDNESS, DeviceSource, open_source, tone
from tests.voice_sounds import loudest_hz
from tests.waiting import wait_until

FRAME_NS = 20_000_000


def wav(path: Path, hz: float, seconds: float, rate_hz: int = 16_000, channels: int = 2) -> Path:
    at_s = np.arange(round(seconds * rate_hz)) / rate_hz
    samples = np.repeat(np.round(8000 * np.sin(2 * np.pi * hz * at_s)), channels).astype("<i2")
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(2)
        file.setframerate(rate_hz)
        file.writeframes(samples.tobytes())
    return path


def test_a_tone_is_quiet_and_has_no_steps() -> None:
    samples = np.concatenate(list(itertools.islice(tone(440.0), 50)))
    assert loudest_hz(samples) == pytest.approx(440.0)
    assert np.abs(samples).max() == pytest.approx(32767 * LOUDNESS, abs=1)
    assert np.abs(np.diff(samples.astype(float))).max() <= 32767 * LOUDNESS * 2 * np.pi * 440 / 48_000 + 2


def test_a_paced_source_gives_each_sound_once_it_has_ended() -> None:
    source = open_source("tone:440")
    assert source.take(1000) == []
    assert source.take(1000 + FRAME_NS - 1) == []
    assert [one.time_ns for one in source.take(1000 + 2 * FRAME_NS)] == [1000, 1000 + FRAME_NS]
    late = source.take(1000 + 1000 * FRAME_NS)
    assert len(late) == 10, "a loop that stood still does not catch up"
    assert source.problem == ""


def test_a_file_of_another_form_is_repeated(tmp_path: Path) -> None:
    source = open_source(wav(tmp_path / "voice.wav", 500.0, 0.31))
    source.take(0)
    found = [one for tick in range(1, 60) for one in source.take(tick * FRAME_NS)]
    assert len(found) == 59
    assert {one.samples.shape for one in found} == {(960,)}
    assert loudest_hz(found[5].samples) == pytest.approx(500.0, abs=30.0)


@pytest.mark.parametrize(
    ("place", "says"),
    [
        ("tone:low", "expected such as tone:440"),
        ("tone:5", "expected such as tone:440"),
        ("none", "expected such as tone:440"),
        (Path("missing.wav"), "missing.wav: No such file"),
    ],
)
def test_a_source_that_is_none_is_refused(place: str | Path, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        open_source(place)


def test_a_file_without_sound_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no sound of 20 ms"):
        open_source(wav(tmp_path / "short.wav", 500.0, 0.01))
    (tmp_path / "text.wav").write_text("no sound")
    with pytest.raises(ValueError, match=r"text\.wav: "):
        open_source(tmp_path / "text.wav")
    with av.open(tmp_path / "film.mkv", "w") as film:
        stream = film.add_stream("mpeg4", rate=10, width=64, height=64, pix_fmt="yuv420p")
        film.mux(stream.encode(av.VideoFrame(64, 64, "yuv420p")))
        film.mux(stream.encode())
    with pytest.raises(ValueError, match=r"film\.mkv: has no sound"):
        open_source(tmp_path / "film.mkv")


has_alsa = pytest.mark.skipif(not Path(FOLDER, "alsa.conf").exists(), reason="the system has no ALSA (libasound2-data)")


@has_alsa
def test_a_microphone_of_alsa_gives_sounds_and_a_missing_one_its_reason() -> None:
    source = DeviceSource("null")
    found = []
    wait_until(lambda: found.extend(source.take(0)) or len(found) > 3, lambda: source.problem)
    assert source.problem == ""
    assert {one.samples.shape for one in found} == {(960,)}
    source.close()
    missing = DeviceSource("no-such-device")
    wait_until(lambda: missing.problem.startswith("alsa:no-such-device: "), lambda: missing.problem)
    assert missing.take(0) == []
    missing.close()


@has_alsa
def test_a_loudspeaker_of_alsa_plays_and_a_missing_one_says_why() -> None:
    sink = DeviceSink("null")
    wait_until(lambda: sink.problem == "", lambda: sink.problem)
    for samples in itertools.islice(tone(440.0), 50):
        sink.play(samples)
    sink.close()
    missing = DeviceSink("no-such-device")
    wait_until(lambda: missing.problem.startswith("alsa:no-such-device: "), lambda: missing.problem)
    missing.play(next(tone(440.0)))
    missing.close()


def test_a_loudspeaker_that_hangs_is_named_and_plays_nothing_of_before(monkeypatch: pytest.MonkeyPatch) -> None:
    device = MagicMock()
    goes_on, hung = threading.Event(), threading.Event()

    def write(_: object) -> None:
        hung.set()
        goes_on.wait()

    device.__enter__.return_value.mux = write
    monkeypatch.setattr("remote_site.voice.sound_sink.av.open", lambda *_, **__: device)
    monkeypatch.setattr("remote_site.voice.sound_sink._HANGS_S", 0.1)
    sink = DeviceSink("stuck")
    wait_until(lambda: sink.problem == "")
    sink.play(next(tone(440.0)))
    wait_until(hung.is_set)
    wait_until(lambda: sink.play(next(tone(440.0))) or sink.problem == "alsa:stuck: takes no sound")
    goes_on.set()
    wait_until(lambda: sink.problem == "")
    assert sink._waiting.qsize() == 0
    sink.close()


def test_a_microphone_that_hangs_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    goes_on = threading.Event()

    def blocks(_: object) -> Iterator[Samples]:
        yield next(tone(440.0))
        goes_on.wait()
        yield next(tone(440.0))
        threading.Event().wait()

    monkeypatch.setattr("remote_site.voice.sound_source.av.open", lambda *_, **__: nullcontext())
    monkeypatch.setattr("remote_site.voice.sound_source._blocks", blocks)
    source = DeviceSource("stuck")
    wait_until(lambda: source.take(time.monotonic_ns()))
    assert source.problem == ""
    source.take(time.monotonic_ns() + 2_000_000_000)
    assert source.problem == "alsa:stuck: gives no sound"
    goes_on.set()
    wait_until(lambda: source.take(time.monotonic_ns()))
    assert source.problem == ""
    source.close()


@pytest.mark.parametrize("kind", [DeviceSource, DeviceSink])
def test_a_device_is_opened_again_after_any_error(
    kind: type[DeviceSource | DeviceSink], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = Mock(side_effect=TypeError("surprise"))
    monkeypatch.setattr("remote_site.voice.sound_sink.av.open", opened)
    for module in ("sound_sink", "sound_source"):
        monkeypatch.setattr(f"remote_site.voice.{module}.AGAIN_S", 0.01)
    device = kind("strange")
    wait_until(lambda: opened.call_count > 1)
    assert device.problem == "alsa:strange: surprise"
    device.close()


@pytest.mark.parametrize("unplugged", [False, True], ids=["missing", "unplugged"])
def test_a_loudspeaker_that_comes_plays_nothing_of_before(unplugged: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    def unplug(sink: DeviceSink, container: object) -> None:
        sink.problem = ""
        wait_until(sink._waiting.full)
        raise OSError("unplugged")

    if unplugged:
        monkeypatch.setattr("remote_site.voice.sound_sink.av.open", lambda *_, **__: nullcontext())
        monkeypatch.setattr(DeviceSink, "_play_all", unplug)
    sink = DeviceSink("no-such-device")
    wait_until(lambda: sink.problem == "" if unplugged else "no-such-device" in sink.problem, lambda: sink.problem)
    for samples in itertools.islice(tone(440.0), 4):
        sink.play(samples)
    wait_until(lambda: "no-such-device" in sink.problem, lambda: sink.problem)
    wait_until(lambda: sink._waiting.qsize() == 0)
    sink.close()


def test_a_wav_file_holds_what_was_played(tmp_path: Path) -> None:
    sink = open_sink(tmp_path / "heard.wav")
    assert isinstance(sink, WavSink)
    played = list(itertools.islice(tone(440.0), 5))
    for samples in played:
        sink.play(samples)
    sink.close()
    with wave.open(str(tmp_path / "heard.wav")) as file:
        assert (file.getnchannels(), file.getframerate()) == (1, 48_000)
        assert file.readframes(10_000) == np.concatenate(played).astype("<i2").tobytes()


def test_a_full_disk_is_a_problem_of_the_sink_and_ends_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sink = open_sink(tmp_path / "heard.wav")
    first, second, third = itertools.islice(tone(440.0), 3)
    with monkeypatch.context() as full:
        full.setattr(wave.Wave_write, "writeframes", Mock(side_effect=OSError(28, "No space left on device")))
        sink.play(first)
        sink.play(second)
    assert "No space left" in sink.problem
    sink.play(third)
    assert not sink.problem
    sink.close()


def test_a_file_on_a_full_disk_ends_without_an_error(tmp_path: Path) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    sink = open_sink(tmp_path / "heard.wav")
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, before[1]))
    try:
        for samples in itertools.islice(tone(440.0), 60):
            sink.play(samples)
        assert sink.problem
        sink.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    with wave.open(str(tmp_path / "heard.wav")) as file:
        assert len(file.readframes(100_000)) > 40_000


def test_a_sink_that_is_none_is_refused(tmp_path: Path) -> None:
    assert isinstance(open_sink("none"), NoSink)
    assert open_sink("none").problem
    with pytest.raises(ValueError, match="expected such as alsa:default"):
        open_sink("tone:440")
    with pytest.raises(ValueError, match=r"has to end in \.wav"):
        open_sink(tmp_path / "heard.mp3")
