"""Pictures of a recording: in order while it plays, and from a key picture on after a jump."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.recording.recorder import Recorder
from operator_site.console.camera.camera_picture import Picture, follows
from operator_site.console.playback.playback import CAMERA, Recording
from operator_site.console.playback.played_media import PlayedPictures

START_NS, S = 7_000_000_000, 1_000_000_000
HZ, SECONDS, KEY_EVERY, LOST, LATE_KEY = 15, 30, 30, 100, 200
"""Picture 100 is lost, and after picture 200 no key picture comes."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Recording]:
    out = tmp_path_factory.mktemp("recorded") / "session.mcap"
    with Recorder(out, {CAMERA: {}, "console/act": {}}, {}) as recorder:
        recorder.write("console/act", START_NS, msgpack.packb({}))
        for number in range(HZ * SECONDS):
            if number == LOST:
                continue
            made = Picture(number, number / HZ, 0.001, number % KEY_EVERY == 0 and number <= LATE_KEY, 160, 96, b"vp8")
            recorder.write(CAMERA, START_NS + number * S // HZ, msgpack.packb(made.record()))
        recorder.write(CAMERA, START_NS + SECONDS * S, b"damaged")
    opened = Recording(out)
    yield opened
    opened.close()


def sequences(pictures: list[Picture]) -> list[int]:
    return [picture.sequence for picture in pictures]


def test_it_plays_each_picture_once_and_drops_those_after_a_lost_one(recording: Recording) -> None:
    played = PlayedPictures(recording)
    found = [picture for at in range(0, SECONDS * 10 + 1) for picture in played.play(START_NS + at * S // 10)]
    assert sequences(found) == [number for number in range(HZ * SECONDS) if not LOST <= number < 120]


@pytest.mark.long
@given(st.floats(0.0, float(SECONDS)))
def test_a_jump_starts_at_the_last_key_picture_before_it(recording: Recording, at_s: float) -> None:
    now_ns = START_NS + round(at_s * S)
    played = PlayedPictures(recording)
    found = played.jump(now_ns)
    newest = max(number for number in range(HZ * SECONDS) if number * S // HZ <= now_ns - START_NS)
    newest = LOST - 1 if LOST <= newest < 120 else newest
    assert found[0].is_key
    assert sum(picture.is_key for picture in found) == 1
    assert all(follows(later, before.sequence) for before, later in pairwise(found))
    assert found[-1].sequence == newest
    later = played.play(now_ns + S)
    assert not later or follows(later[0], newest)


def test_a_recording_without_pictures_has_none(tmp_path: Path) -> None:
    out = tmp_path / "session.mcap"
    with Recorder(out, {"console/act": {}}, {}) as recorder:
        recorder.write("console/act", START_NS, msgpack.packb({}))
    opened = Recording(out)
    assert not opened.has(CAMERA)
    opened.close()
