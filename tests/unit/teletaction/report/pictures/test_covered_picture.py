"""Covered pictures: of the simulated patient's face nothing is left, and the place of the contact stays."""

from io import BytesIO
from typing import Any

import av
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from common.fingers import FINGERS
from common.recording.camera_marks import VERB
from common.scenes.scene import load_scene
from operator_site.console.camera.camera_picture import Picture
from remote_site.camera.video_encoder import VideoEncoder
from sim_sensors.physics.camera_view import CameraView
from teletaction.report.pictures.covered_picture import COVER, covered, marked_places
from teletaction.report.pictures.finding_stills import stills

WIDTH, HEIGHT = 640, 360
Pixels = NDArray[np.float64]
MARKS = {f"{name}{n}": value for n, (u, v) in enumerate(((0.3, 0.3), (0.6, 0.3), (0.6, 0.7), (0.3, 0.7)), 1)
         for name, value in (("u", u), ("v", v), ("x", 100.0 * u), ("y", -100.0 * v))}  # fmt: skip
ACTS: dict[Any, dict[str, Any]] = {1: {"verb": VERB, "at_s": 5.0, "ok": True, "details": MARKS}}
FACE = (slice(0, HEIGHT // 4 + 8), slice(WIDTH - HEIGHT // 4 - 8, WIDTH))


def filmed(force_n: float) -> Picture:
    """The simulated camera's picture with the index finger in the middle, as the codec has it."""
    view = CameraView(load_scene("materials"), ("index",), WIDTH, HEIGHT)
    x_m = (0.5 * WIDTH - view.place(0.0, 0.0)[0]) / (view.place(1.0, 0.0)[0] - view.place(0.0, 0.0)[0])
    forces = np.zeros(len(FINGERS))
    forces[FINGERS.index("index")] = force_n
    planes = np.frombuffer(view.draw(1.0, x_m, 0.0, forces), np.uint8).reshape(HEIGHT * 3 // 2, WIDTH)
    encoded = VideoEncoder(WIDTH, HEIGHT, 15.0, 400_000).encode(
        av.VideoFrame.from_ndarray(planes, "yuv420p"), 10**9, True
    )
    assert encoded is not None
    return Picture(1, 10.0, 0.0, True, WIDTH, HEIGHT, encoded.data)


def still(force_n: float, acts: dict[Any, dict[str, Any]] | None) -> Pixels:
    """The still of a finding at 10 s; covered as the acts say, or not at all."""
    cover = None if acts is None else (lambda pixels, at_s: covered(pixels, marked_places(acts, at_s)))
    jpeg = stills([filmed(force_n)], {1: 10.0}, cover)[1].jpeg
    return np.asarray(Image.open(BytesIO(jpeg)).convert("RGB"), np.float64)


@pytest.fixture(scope="module")
def calm() -> Pixels:
    return still(0.1, ACTS)


@pytest.fixture(scope="module")
def wince() -> Pixels:
    return still(5.0, ACTS)


def tiles(face: Pixels, rows: int, columns: int) -> Pixels:
    """Mean of each tile of a picture."""
    return np.array([[part.mean() for part in np.array_split(row, columns, 1)] for row in np.array_split(face, rows)])


def test_a_calm_face_and_one_in_pain_are_the_same_after_covering(calm: Pixels, wince: Pixels) -> None:
    """The difference of the means is far below the noise of the codec in the open picture, 1 grey level."""
    open_calm, open_wince = still(0.1, None), still(5.0, None)
    assert np.abs(tiles(open_calm[FACE], 4, 4) - tiles(open_wince[FACE], 4, 4)).max() > 30.0, "the open face differs"
    assert np.abs(tiles(open_calm, 8, 12) - tiles(open_wince, 8, 12)).max() > 5.0, "so do the tiles of a mosaic"
    assert np.abs(calm[FACE] - wince[FACE]).max() == 0.0
    assert np.abs(calm[FACE] - COVER).max() <= 1.0


def test_the_place_of_the_contact_stays_visible(calm: Pixels) -> None:
    shown = still(0.1, None)
    middle = (slice(HEIGHT // 2 - 40, HEIGHT // 2 + 40), slice(WIDTH // 2 - 40, WIDTH // 2 + 40))
    assert np.abs(calm[middle] - shown[middle]).mean() < 2.0
    assert shown[middle].std() > 20.0


def test_without_marks_all_of_it_is_covered() -> None:
    broken = {**ACTS[1], "details": {**MARKS, "u1": 1.5}}
    late, refused = {**ACTS[1], "at_s": 11.0}, {**ACTS[1], "ok": False}
    for acts in ({}, {1: broken}, {1: late}, {1: refused}, {1: {"verb": VERB, "at_s": 1.0, "ok": True}}):
        assert np.abs(still(5.0, acts) - COVER).max() <= 1.0


def test_the_newest_marks_count() -> None:
    newer = {**ACTS[1], "at_s": 7.0, "details": {**MARKS, "u1": 0.35}}
    assert (marked_places({1: newer, 2: ACTS[1]}, 10.0) or ())[0] == (0.35, 0.3)
    assert (marked_places({1: newer, 2: ACTS[1]}, 6.0) or ())[0] == (0.3, 0.3)
