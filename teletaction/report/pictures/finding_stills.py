"""Finds the camera's picture at the moment of each finding in a recording."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from operator_site.console.camera.camera_picture import Picture, follows
from operator_site.console.camera.still_picture import PictureDecoder, jpeg_of

LATE_S = 1.0
"""Largest age of a picture at the moment that it shows, s."""
Pixels = NDArray[np.uint8]
Cover = Callable[[Pixels, float], Pixels]
"""Returns a picture, (rows, columns, 3), with a part of it covered, from the picture and its moment, s."""


class Still(NamedTuple):
    """A picture of the camera.

    Attributes:
        jpeg: the picture as a JPEG file.
        before_s: time from its capture to the finding, s.
        uncertainty_s: bound of the error of the time of capture, s.
        is_covered: whether a part of it is covered.
    """

    jpeg: bytes
    before_s: float
    uncertainty_s: float
    is_covered: bool = False


def stills(pictures: Iterable[Picture], moments_s: Mapping[int, float], cover: Cover | None = None) -> dict[int, Still]:
    """Return the newest picture at each moment, by the moment's key; a moment without a sound one is left out.

    Args:
        pictures: recorded pictures in order; only those since the last key picture are kept.
        moments_s: times of the operator site's clock, s.
        cover: covers a part of each picture; by default all of it is shown.

    Raises:
        ModuleNotFoundError: the extra `camera` is not installed.
    """
    left = sorted(moments_s.items(), key=lambda moment: moment[1])
    found: dict[int, Still] = {}
    since_key: list[Picture] = []
    for picture in pictures:
        while left and picture.captured_s > left[0][1]:
            _decode(since_key, *left.pop(0), cover, found)
        if picture.is_key or not since_key or not follows(picture, since_key[-1].sequence):
            since_key = []
        if picture.is_key or since_key:
            since_key.append(picture)
    for moment in left:
        _decode(since_key, *moment, cover, found)
    return found


def _decode(since_key: list[Picture], key: int, at_s: float, cover: Cover | None, found: dict[int, Still]) -> None:
    """Decode the newest of these pictures, unless it is too old."""
    if not since_key or at_s - since_key[-1].captured_s > LATE_S:
        return
    try:
        frame = PictureDecoder().decode(since_key)
    except ValueError:  # a damaged or empty picture is left out
        return
    if cover is not None:
        pixels = cover(np.asarray(frame.to_ndarray(format="rgb24"), np.uint8), at_s)
        frame = frame.from_ndarray(pixels, "rgb24")
    newest = since_key[-1]
    found[key] = Still(jpeg_of(frame), at_s - newest.captured_s, newest.uncertainty_s, cover is not None)
