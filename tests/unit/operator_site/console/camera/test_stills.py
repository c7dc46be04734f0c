"""Still pictures for browsers that decode none: of which pictures they are made, how often, and by what process."""

import os
import signal
import time
from collections.abc import Iterator
from concurrent.futures import Future
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest

from operator_site.console.camera.camera_picture import Picture
from operator_site.console.camera.still_process import StillProcess
from operator_site.console.camera.stills import STILL_S, Stills
from tests.vp8_stream import HEIGHT, HZ, WIDTH, pictures


def picture(sequence: int, *, is_key: bool = False) -> Picture:
    return Picture(sequence, 1.0 + sequence / HZ, 0.001, is_key, WIDTH, HEIGHT, b"vp8")


class Making:
    """Answers when the test says so."""

    def __init__(self) -> None:
        self.asked: list[list[int]] = []
        self.running: Future[Picture] = Future()
        self._last = picture(0)

    def __call__(self, given: list[Picture]) -> "Future[Picture]":
        self.asked.append([one.sequence for one in given])
        self.running, self._last = Future(), given[-1]
        return self.running

    def done(self) -> None:
        self.running.set_result(self._last)


def test_the_newest_picture_becomes_a_still_one_twice_a_second() -> None:
    making = Making()
    stills = Stills(making)
    assert stills.wants_key
    stills.take(picture(1))  # nothing can be decoded before a key picture
    assert stills.wants_key
    stills.take(picture(2, is_key=True))
    assert not stills.wants_key
    assert stills.step(10.0, wanted=True) is None
    stills.take(picture(3))
    assert stills.step(10.0 + STILL_S, wanted=True) is None  # the first one is not made yet
    making.done()
    stills.take(picture(4))
    assert stills.step(10.0 + STILL_S, wanted=True) == picture(2, is_key=True)
    making.done()
    stills.take(picture(5))
    assert stills.step(10.1 + STILL_S, wanted=True) == picture(4)
    assert stills.step(10.2 + STILL_S, wanted=True) is None
    assert making.asked == [[2], [3, 4]]
    assert stills.step(10.0 + 2 * STILL_S, wanted=False) is None
    assert stills.step(10.0 + 2 * STILL_S, wanted=True) is None
    assert making.asked == [[2], [3, 4], [5]]


def test_a_key_picture_spares_the_pictures_before_it() -> None:
    making = Making()
    stills = Stills(making)
    for number in range(1, 11):
        stills.take(picture(number, is_key=number in (1, 9)))
    stills.step(0.0, wanted=True)
    assert making.asked == [[9, 10]]


def test_after_a_gap_or_a_failure_it_waits_for_a_key_picture() -> None:
    making = Making()
    stills = Stills(making)
    stills.take(picture(1, is_key=True))
    stills.take(picture(3))
    assert stills.wants_key
    stills.take(picture(4, is_key=True))
    stills.step(0.0, wanted=True)
    making.running.set_exception(ValueError("damaged"))
    assert stills.step(1.0, wanted=True) is None
    assert stills.wants_key
    stills.take(picture(5))
    assert stills.step(2.0, wanted=True) is None
    assert making.asked == [[4]]


def test_what_was_begun_before_a_jump_is_not_shown() -> None:
    making = Making()
    stills = Stills(making)
    stills.take(picture(1, is_key=True))
    stills.step(0.0, wanted=True)
    stills.clear()
    making.done()
    stills.take(picture(100, is_key=True))
    assert stills.step(0.1, wanted=True) is None
    assert stills.newest is None
    stills.step(STILL_S, wanted=True)
    making.done()
    assert stills.step(1.0, wanted=True) == picture(100, is_key=True) == stills.newest


def test_without_key_pictures_few_pictures_wait() -> None:
    stills = Stills(Making())
    for number in range(1, 5000):
        stills.take(picture(number, is_key=number == 1))
        assert len(stills._waiting) <= 300
    assert stills.wants_key


@pytest.fixture
def process() -> Iterator[StillProcess]:
    pytest.importorskip("av", reason="needs the extra `camera`")
    made = StillProcess()
    yield made
    made.close()


def stream() -> list[Picture]:
    return [
        Picture(number, 1.0 + number / HZ, 0.001, is_key, WIDTH, HEIGHT, content)
        for number, (is_key, content) in enumerate(pictures())
    ]


def left_px(jpeg: bytes) -> int:
    """Left edge of the bright square, pixels."""
    from PIL import Image

    row = np.asarray(Image.open(BytesIO(jpeg)).convert("L"))[HEIGHT // 2]
    return int(np.argmax(row > 150))


@pytest.mark.timeout(120)
def test_the_process_makes_a_jpeg_file_of_the_last_picture_and_survives_damage(process: StillProcess) -> None:
    coded = stream()
    for part in (coded[:4], coded[4:9]):
        made = process.make(part).result(60)
        assert left_px(made.content) == pytest.approx(4 * part[-1].sequence, abs=2)
        assert (made.captured_s, made.sequence, made.is_key) == (part[-1].captured_s, part[-1].sequence, True)
    damaged = Picture(99, 0.0, 0.0, True, WIDTH, HEIGHT, b"\xff" * 50)
    with pytest.raises(ValueError, match="Error"):
        process.make([damaged]).result(60)
    with pytest.raises(ValueError, match="empty picture"):
        process.make([replace(damaged, content=b"")]).result(60)
    assert left_px(process.make(coded[:2]).result(60).content) == pytest.approx(4, abs=2)
    assert process._process is not None
    process._process.kill()
    with pytest.raises((OSError, EOFError)):
        process.make(coded[:1]).result(60)
    assert left_px(process.make(coded[:3]).result(60).content) == pytest.approx(8, abs=2)


def test_closing_does_not_wait_for_a_process_that_hangs(process: StillProcess) -> None:
    process.make(stream()[:1]).result(60)
    assert process._process is not None
    assert process._process.pid is not None
    os.kill(process._process.pid, signal.SIGSTOP)
    waits = process.make(stream()[:1])
    began_s = time.monotonic()
    process.close()
    assert time.monotonic() - began_s < 5.0
    assert waits.done()
    assert process._process is None
