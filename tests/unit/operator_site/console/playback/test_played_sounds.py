"""Sounds of a recording: in order while it plays, one talker at a time, and from the shown moment on after a jump."""

from collections.abc import Iterator

import msgpack
import pytest

from common.recording.recorder import Recorder
from operator_site.console.playback.playback import VOICE, Recording
from operator_site.console.playback.played_media import PlayedSounds
from operator_site.console.voice.voice_sound import Direction, VoiceSound

START_NS, S, FRAME_NS = 7_000_000_000, 1_000_000_000, 20_000_000
COUNT, SAID = 500, range(200, 250)
"""Sounds of the remote site, and those during which a page talks."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Recording]:
    out = tmp_path_factory.mktemp("recorded") / "session.mcap"
    with Recorder(out, {VOICE: {}, "console/act": {}}, {}) as recorder:

        def write(direction: Direction, number: int, late_ns: int) -> None:
            sound = VoiceSound(direction, number, (START_NS + number * FRAME_NS) * 1e-9, 0.001, b"opus")
            recorder.write(VOICE, START_NS + number * FRAME_NS + late_ns, msgpack.packb(sound.record()))

        recorder.write("console/act", START_NS, msgpack.packb({}))
        for number in range(COUNT):
            if number in SAID:
                write("to_remote", number, 0)
            write("from_remote", number, 1_000_000)
        recorder.write(VOICE, START_NS + COUNT * FRAME_NS, b"damaged")
    opened = Recording(out)
    yield opened
    opened.close()


def numbers(sounds: list[VoiceSound]) -> list[int]:
    return [sound.sequence for sound in sounds]


def test_it_plays_each_moment_once_and_one_talker_at_a_time(recording: Recording) -> None:
    assert recording.has(VOICE)
    played = PlayedSounds(recording)
    found = [sound for at in range(COUNT) for sound in played.play(START_NS + (at + 1) * FRAME_NS)]
    assert sum(sound.direction == "to_remote" for sound in found) == len(SAID)
    paused = range(SAID.stop, SAID.stop + 2)
    assert numbers(found) == [number for number in range(COUNT) if number not in paused]


def test_a_jump_continues_at_its_moment(recording: Recording) -> None:
    played = PlayedSounds(recording)
    played.jump(START_NS + S)
    assert numbers(played.play(START_NS + S + 3 * FRAME_NS)) == [50, 51, 52]
