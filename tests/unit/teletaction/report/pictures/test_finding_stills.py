"""The camera's picture at the moment of a finding, from recorded bytes of the codec."""

from dataclasses import replace
from fractions import Fraction
from io import BytesIO
from pathlib import Path

import av
import msgpack
import numpy as np
import pytest
from PIL import Image

from common.recording.recorder import Recorder
from operator_site.console.camera.camera_picture import Picture
from remote_site.camera.video_encoder import VideoEncoder
from teletaction.report.pictures.finding_stills import LATE_S, stills
from teletaction.report.session_report import report
from tests.unit.teletaction.recorded_examination import record_findings

WIDTH, HEIGHT, RATE_HZ = 64, 64, 10.0
BEGIN_S = 100.0


def grey(number: int) -> int:
    return 40 + 8 * number


@pytest.fixture(scope="module")
def pictures() -> list[Picture]:
    """Twenty pictures, each lighter than the one before; the first and the eleventh are key pictures."""
    encoder, found = VideoEncoder(WIDTH, HEIGHT, RATE_HZ, 500_000), []
    for number in range(20):
        frame = av.VideoFrame.from_ndarray(np.full((HEIGHT, WIDTH), grey(number), np.uint8), "gray")
        frame.time_base = Fraction(1, 1000)
        encoded = encoder.encode(frame, round((BEGIN_S + number / RATE_HZ) * 1e9), number in (0, 10))
        assert encoded is not None
        found.append(
            Picture(number + 1, BEGIN_S + number / RATE_HZ, 0.0004, encoded.is_key, WIDTH, HEIGHT, encoded.data)
        )
    return found


def shown(jpeg: bytes) -> float:
    return float(np.asarray(Image.open(BytesIO(jpeg)).convert("L")).mean())


def test_each_moment_shows_the_newest_picture_before_it(pictures: list[Picture]) -> None:
    assert [picture.sequence for picture in pictures if picture.is_key] == [1, 11]
    moments_s = {7: BEGIN_S + 0.55, 3: BEGIN_S + 1.25, 9: BEGIN_S + 1.95}
    found = stills(pictures, moments_s)
    assert set(found) == set(moments_s)
    for key, number in ((7, 5), (3, 12), (9, 19)):
        assert shown(found[key].jpeg) == pytest.approx(grey(number), abs=5.0)
        assert found[key].before_s == pytest.approx(0.05, abs=1e-6)
        assert found[key].uncertainty_s == 0.0004


@pytest.mark.long
def test_the_report_shows_the_picture_with_its_finding(pictures: list[Picture], tmp_path: Path) -> None:
    session, camera = record_findings(tmp_path / "session.mcap", [{}, {}]), tmp_path / "console.mcap"
    with Recorder(camera, {"console/camera": {}}, {}) as recorder:
        for picture in pictures:
            at_s = picture.captured_s - BEGIN_S + 1.5
            recorder.write("console/camera", round(at_s * 1e9), msgpack.packb({**picture.record(), "captured_s": at_s}))
    report([session, camera], out := tmp_path / "report.html")
    html = out.read_text("utf-8")
    assert html.count("data:image/jpeg;base64,") == 2
    for number in (1, 2):
        assert f"Camera at finding {number}" in html
    assert "s before the mark, ± 0 ms" in html


def test_a_moment_without_a_recent_picture_shows_none(pictures: list[Picture]) -> None:
    moments_s = {1: BEGIN_S - 0.1, 2: BEGIN_S + 1.9 + LATE_S + 0.1}
    assert stills(pictures, moments_s) == {}
    assert stills([], {1: 0.0}) == {}


def test_after_a_lost_picture_nothing_is_shown_until_the_next_key_picture(pictures: list[Picture]) -> None:
    with_gap = [picture for picture in pictures if picture.sequence != 4]
    found = stills(with_gap, {1: BEGIN_S + 0.25, 2: BEGIN_S + 0.75, 3: BEGIN_S + 1.05})
    assert set(found) == {1, 3}


@pytest.mark.parametrize("content", [b"", b"no picture", bytes(100)], ids=len)
def test_a_damaged_picture_shows_nothing_and_the_others_are_shown(pictures: list[Picture], content: bytes) -> None:
    damaged = [replace(picture, content=content) if picture.sequence == 1 else picture for picture in pictures]
    assert set(stills(damaged, {1: BEGIN_S + 0.25, 2: BEGIN_S + 1.05})) == {2}
