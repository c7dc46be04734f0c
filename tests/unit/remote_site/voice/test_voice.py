"""The voice's process against readers with real keys: both ways, who may talk, mute, loss and damage."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from pathlib import Path

import pytest
import zmq

from common.config.link_models import RemoteLinkConfig
from common.config.stream_models import VoiceConfig
from common.link.curve import LinkProblem, prepare_socket, use_curve
from common.link.keys import Role, TrustedKeys, fingerprint, load_keys
from common.link.local_control import ask_desk
from common.link.session_state import Refused
from common.link.voice_end import Sound, VoiceEnd
from common.wire.streams import STREAMS
from common.wire.voice_messages import VoiceState
from remote_site import stream_server
from remote_site.stream_server import LEFT_S, MOST_READERS, StreamServer
from remote_site.voice import voice as voice_module
from remote_site.voice.opus_codec import Samples
from remote_site.voice.session_holder import SessionHolder
from remote_site.voice.sound_source import open_source
from remote_site.voice.voice import YIELD_S, Voice, run_voice
from tests.conftest import Keys
from tests.ports import free_ports
from tests.voice_sounds import coded_tone, decoded, loudest_hz
from tests.waiting import wait_until

pytestmark = pytest.mark.timeout(60)


class Heard:
    """A loudspeaker that keeps what it plays."""

    problem = ""

    def __init__(self) -> None:
        self.played: list[Samples] = []

    def play(self, samples: Samples) -> None:
        self.played.append(samples)

    def close(self) -> None:
        pass


class Reader:
    """A reader of the stream, which talks when it is asked to."""

    def __init__(self, socket: "zmq.Socket[bytes]", state: VoiceState = VoiceState.MUTED) -> None:
        self.socket, self.state = socket, state
        self.end = VoiceEnd(time.monotonic_ns())
        self.sounds: list[Sound] = []
        self.ages_s: list[float] = []
        self._tone = iter(coded_tone(1000.0, 200))
        self._due_ns = 0

    def turn(self) -> None:
        while self.socket.poll(0):
            now_ns = time.monotonic_ns()
            if (sound := self.end.take(self.socket.recv(), now_ns)) is not None:
                self.sounds.append(sound)
                self.ages_s.append((now_ns - sound.captured_ns) * 1e-9)
        now_ns = time.monotonic_ns()
        sound_out = None
        if self.state is VoiceState.TALKS and now_ns >= self._due_ns and self.end.far is not None:
            self._due_ns = max(self._due_ns, now_ns - 40_000_000) + 20_000_000
            sound_out = now_ns - 20_000_000, next(self._tone)
        self.send(self.end.pack(now_ns, self.state, sound_out, hears=True, consents=True))

    def send(self, packed: bytes | None) -> None:
        if packed is not None:
            with suppress(zmq.Again):  # it is cut off
                self.socket.send(packed, zmq.DONTWAIT)


class Stage:
    """The voice's process in this thread, and readers."""

    def __init__(self, keys: Keys, base_port: int, opened: ExitStack, *, consents: bool = False) -> None:
        self.keys, self.base_port, self.heard = keys, base_port, Heard()
        link = RemoteLinkConfig(base_port=base_port, keys=keys.remote)
        self.server = opened.enter_context(closing(StreamServer(link, "voice")))
        self.voice = Voice(self.server, open_source("tone:440"), self.heard, consents=consents)
        self._context = zmq.Context()
        opened.callback(self._context.destroy, 0)
        self.readers: list[Reader] = []
        """Readers that take part."""
        self._all: list[Reader] = []

    def reader(self, own: str = "operator", state: VoiceState = VoiceState.MUTED) -> Reader:
        socket: zmq.Socket[bytes] = self._context.socket(zmq.DEALER)
        prepare_socket(socket)
        use_curve(socket, load_keys(getattr(self.keys, own)), load_keys(self.keys.remote).public)
        socket.connect(f"tcp://127.0.0.1:{self.base_port + STREAMS['voice'].port}")
        self.readers.append(reader := Reader(socket, state))
        self._all.append(reader)
        return reader

    def until(self, reached: Callable[[], object]) -> None:
        """Run everything until something is reached."""

        def turn() -> object:
            self.voice.step(time.monotonic_ns())
            for reader in self.readers:
                reader.turn()
            return reached()

        wait_until(turn, self.voice.figures, every_s=0.002)


@pytest.fixture
def stage(keys: Keys, base_port: int) -> Iterator[Stage]:
    with ExitStack() as opened:
        yield Stage(keys, base_port, opened)


@pytest.mark.long
def test_the_microphone_is_heard_with_the_time_of_each_sound(stage: Stage) -> None:
    reader = stage.reader()
    stage.until(lambda: len(reader.sounds) >= 50)
    assert loudest_hz(decoded([sound.content for sound in reader.sounds])) == pytest.approx(440.0, abs=4.0)
    began = [sound.captured_ns for sound in reader.sounds]
    assert began == sorted(began)
    numbers = [sound.sequence for sound in reader.sounds]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert min(reader.ages_s) >= 0.019, "a sound can be sent when it has ended"
    assert sorted(reader.ages_s)[len(began) // 2] < 0.2


@pytest.mark.long
def test_who_may_operate_is_played_and_named(stage: Stage) -> None:
    reader = stage.reader(state=VoiceState.TALKS)
    stage.until(lambda: len(stage.heard.played) >= 40)
    assert loudest_hz(stage.heard.played[20]) == pytest.approx(1000.0, abs=50.0)
    assert stage.voice.figures()["physician"] == "talks"
    reader.state = VoiceState.MUTED
    stage.until(lambda: stage.voice.figures()["physician"] == "muted")
    stage.readers.clear()
    stage.until(lambda: stage.voice.figures()["physician"] == "absent")
    assert stage.voice.figures()["readers"] == 0


def test_an_observer_hears_and_is_not_played(stage: Stage, keys: Keys) -> None:
    TrustedKeys(keys.remote).trust("observer", load_keys(keys.stranger).public, Role.OBSERVER)
    observer = stage.reader("stranger", VoiceState.TALKS)
    stage.until(lambda: observer.sounds and stage.voice.counts["refused"] > 5)
    assert stage.heard.played == []
    assert stage.voice.figures()["physician"] == "absent"


def test_an_operator_that_becomes_an_observer_is_no_longer_played(stage: Stage, keys: Keys) -> None:
    reader = stage.reader(state=VoiceState.TALKS)
    stage.until(lambda: stage.heard.played)
    trusted = TrustedKeys(keys.remote)
    trusted.trust(trusted.owners()[own := load_keys(keys.operator).public].name, own, Role.OBSERVER)
    stage.until(lambda: stage.voice.counts["refused"] > 5)
    assert reader.sounds
    assert stage.voice.figures()["physician"] == "absent"


@pytest.mark.long
def test_one_talks_at_a_time_and_the_next_one_after_a_pause(stage: Stage) -> None:
    first, second = stage.reader(state=VoiceState.TALKS), stage.reader()
    stage.until(lambda: len(stage.heard.played) >= 5)
    second.state = VoiceState.TALKS
    stage.until(lambda: stage.voice.counts["refused"] > 5)
    first.state = VoiceState.MUTED
    refused, since_s = stage.voice.counts["refused"], time.monotonic()
    stage.until(lambda: time.monotonic() - since_s > YIELD_S + 0.2 and stage.voice.counts["refused"] > refused)
    played = len(stage.heard.played)
    stage.until(lambda: len(stage.heard.played) > played + 5)


def test_while_an_operator_has_the_session_no_other_one_is_played(stage: Stage, keys: Keys, tmp_path: Path) -> None:
    TrustedKeys(keys.remote).trust("second", load_keys(keys.stranger).public)
    holder = stage.voice.holder = SessionHolder(status := tmp_path / "remote.json")
    second = stage.reader("stranger", VoiceState.TALKS)
    holder.look(time.monotonic_ns())
    stage.until(lambda: len(stage.heard.played) >= 5)

    def of(own: str) -> None:
        """Let the key of `own` have the session."""
        key = fingerprint(load_keys(getattr(keys, own)).public)
        status.write_text(json.dumps({"time_ns": time.monotonic_ns(), "state": "engaged", "operator": key}), "utf-8")
        holder.look(time.monotonic_ns())

    of("operator")
    refused = stage.voice.counts["refused"]
    stage.until(lambda: stage.voice.counts["refused"] > refused + 20)
    assert stage.voice.physician() is VoiceState.ABSENT
    played = len(stage.heard.played)
    operator = stage.reader(state=VoiceState.TALKS)
    stage.until(lambda: len(stage.heard.played) > played + 5)
    assert second.state is VoiceState.TALKS, "both talk, and one is heard"
    of("stranger")
    operator.state = VoiceState.MUTED
    played = len(stage.heard.played)
    stage.until(lambda: len(stage.heard.played) > played + 20)


@pytest.mark.long
def test_a_muted_microphone_sends_nothing_and_says_so(stage: Stage) -> None:
    reader = stage.reader()
    stage.until(lambda: reader.sounds)
    assert stage.voice.answer("mute_voice") == {"muted": True, "physician": "muted"}
    stage.until(lambda: reader.end.far is not None and reader.end.far.state is VoiceState.MUTED)
    count, since_s = len(reader.sounds), time.monotonic()
    stage.until(lambda: time.monotonic() - since_s > 0.3)
    assert len(reader.sounds) == count
    stage.voice.answer("unmute_voice")
    stage.until(lambda: len(reader.sounds) > count)
    with pytest.raises(Refused, match="engage is not for the voice"):
        stage.voice.answer("engage")


@pytest.mark.long
def test_a_key_that_is_not_trusted_hears_nothing_and_a_revoked_one_no_more(stage: Stage, keys: Keys) -> None:
    stranger, reader = stage.reader("stranger"), stage.reader()
    stage.until(lambda: len(reader.sounds) >= 5)
    assert stranger.end.far is None
    TrustedKeys(keys.remote).revoke("operator")
    stage.server.recheck_keys()
    stage.until(lambda: stage.voice.figures()["readers"] == 0)
    count = len(reader.sounds)
    stage.until(lambda: stage.server.socket is not None)
    assert len(reader.sounds) == count


@pytest.mark.long
def test_a_reader_that_reads_nothing_gets_no_queue_of_sounds(stage: Stage) -> None:
    reader, other = stage.reader(), stage.reader()
    stage.until(lambda: reader.sounds and other.sounds)
    stage.readers.remove(reader)
    since_s = time.monotonic()
    stage.until(lambda: time.monotonic() - since_s > LEFT_S + 0.5)
    waiting = 0
    while reader.socket.poll(0):
        reader.socket.recv()
        waiting += 1
    assert waiting < 60, "sounds end without acknowledgements, packets when the reader counts as gone"
    assert len(other.sounds) > 60


def test_damaged_and_oversized_packets_end_nothing(stage: Stage) -> None:
    reader = stage.reader()
    for noise in (b"", b"\xff" * 100, b"x" * 5000):
        reader.send(noise)
    stage.until(lambda: stage.voice.counts["damaged"] == 3)
    reader.send(b"x" * 20_000)  # the connection ends, and begins again
    stage.until(lambda: reader.sounds)


def test_what_is_no_sound_is_counted_and_not_played(stage: Stage) -> None:
    reader = stage.reader()
    stage.until(lambda: reader.sounds)

    def say_noise() -> bool:
        now_ns = time.monotonic_ns()
        sound = now_ns - 20_000_000, b"\xff" * 60
        reader.send(reader.end.pack(now_ns, VoiceState.TALKS, sound, hears=True, consents=True))
        return stage.voice.counts["undecodable"] > 0

    stage.until(say_noise)
    assert stage.heard.played == []


@pytest.mark.long
def test_more_readers_than_places_are_refused(stage: Stage) -> None:
    readers = [stage.reader() for _ in range(MOST_READERS + 1)]
    stage.until(lambda: stage.voice.counts["readers refused"] > 0)
    stage.until(lambda: sum(bool(reader.sounds) for reader in readers) == MOST_READERS)


def test_observers_take_no_place_of_an_operator(stage: Stage, keys: Keys) -> None:
    TrustedKeys(keys.remote).trust("observer", load_keys(keys.stranger).public, Role.OBSERVER)
    observers = [stage.reader("stranger") for _ in range(MOST_READERS)]
    stage.until(lambda: all(observer.sounds for observer in observers))
    operator = stage.reader()
    stage.until(lambda: operator.sounds)
    assert stage.voice.figures()["readers"] == MOST_READERS


def test_idle_connections_of_an_observer_keep_no_operator_out(
    stage: Stage, keys: Keys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stream_server, "MOST_FOR_OBSERVERS", 2)
    TrustedKeys(keys.remote).trust("observer", load_keys(keys.stranger).public, Role.OBSERVER)
    observers = [stage.reader("stranger") for _ in range(MOST_READERS)]
    stage.until(lambda: any(observer.sounds for observer in observers))
    operator = stage.reader()
    stage.until(lambda: operator.sounds)
    assert sum(bool(observer.sounds) for observer in observers) <= 2


@pytest.mark.parametrize("consents", [False, True])
def test_sound_counts_as_recorded_where_both_sides_agree(keys: Keys, base_port: int, consents: bool) -> None:
    with ExitStack() as opened:
        stage = Stage(keys, base_port, opened, consents=consents)
        reader = stage.reader()
        stage.until(lambda: len(reader.sounds) >= 3)
        assert reader.end.far is not None
        assert reader.end.far.consents is consents
        assert stage.voice.figures()["recorded"] is consents


REMOTE = """
[link]
keys = "{keys}"
[texture]
index = "pty"
[thermal_sensors]
index = "pty2"
[telemanipulator]
interface = "virtual"
[calibration]
materials = "m"
surfaces = "s"
[consent]
touch = true
pain = true
voice = true
"""


@pytest.fixture
def own_priority(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the priority of this process, which would stay for the other tests."""
    monkeypatch.setattr(voice_module.os, "nice", lambda by: None)


@pytest.mark.long
@pytest.mark.usefixtures("own_priority")
def test_the_process_runs_with_its_desk_its_status_and_the_patients_consent(
    keys: Keys, base_port: int, tmp_path: Path
) -> None:
    remote = tmp_path / "remote.toml"
    remote.write_text(f'fingers = ["index"]\n{REMOTE.format(keys=keys.remote)}')
    desk, status, over = free_ports(), tmp_path / "voice.json", threading.Event()
    config = VoiceConfig(
        link=RemoteLinkConfig(base_port=base_port, keys=keys.remote),
        source="tone:440",
        sink="none",
        desk_port=desk,
        remote=remote,
        status=status,
    )
    thread = threading.Thread(target=run_voice, args=(config, over.is_set))
    thread.start()
    try:
        wait_until(status.exists)
        assert ask_desk(desk, load_keys(keys.remote), "mute_voice")["muted"] is True
        wait_until(lambda: '"muted": true' in status.read_text())
        with ExitStack() as opened:
            context = zmq.Context()
            opened.callback(context.destroy, 0)
            socket: zmq.Socket[bytes] = context.socket(zmq.DEALER)
            prepare_socket(socket)
            use_curve(socket, load_keys(keys.operator), load_keys(keys.remote).public)
            socket.connect(f"tcp://127.0.0.1:{base_port + STREAMS['voice'].port}")
            reader = Reader(socket)
            wait_until(lambda: reader.turn() or reader.end.far is not None)
            assert reader.end.far is not None
            assert (reader.end.far.consents, reader.end.far.hears) == (True, False)
    finally:
        over.set()
        thread.join()


@pytest.mark.usefixtures("own_priority")
def test_a_second_start_leaves_the_sound_file_of_the_running_voice(keys: Keys, base_port: int, tmp_path: Path) -> None:
    sounds = tmp_path / "heard.wav"
    sounds.write_bytes(b"of the running voice")
    link = RemoteLinkConfig(base_port=base_port, keys=keys.remote)
    with closing(StreamServer(link, "voice")), pytest.raises(LinkProblem, match="in use"):
        run_voice(VoiceConfig(link=link, source="tone:440", sink=sounds, desk_port=base_port + 9), lambda: True)
    assert sounds.read_bytes() == b"of the running voice"
