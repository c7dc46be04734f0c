"""Covers a camera's picture outside the surroundings of the marks that registered it with the map.

No face is searched for, because a face that is not found would be shown. The covered part has one colour, because the
tiles of a mosaic differ between a calm face and one in pain.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.path import Path as Outline
from numpy.typing import NDArray

from common.recording.camera_marks import MARKS, VERB, are_marks

Pixels = NDArray[np.uint8]
Places = tuple[tuple[float, float], ...]
"""Places in a picture: parts of its width from the left and of its height from the top, 0..1."""
GROWN = 1.25
"""Size of the visible part as a multiple of the figure that the marks form."""
COVER = 128
"""Grey of the covered part, of 255."""


def marked_places(acts: Mapping[Any, Mapping[str, Any]], at_s: float) -> Places | None:
    """Return the places of the marks that were valid at a time, s of the recorded acts' clock; None without any."""
    before = [act for act in acts.values() if act["verb"] == VERB and act.get("ok") and act["at_s"] <= at_s]
    if not before:
        return None
    details = max(before, key=lambda act: float(act["at_s"])).get("details")
    if not isinstance(details, Mapping) or not are_marks(details):
        return None
    return tuple((float(details[f"u{number}"]), float(details[f"v{number}"])) for number in range(1, MARKS + 1))


def covered(pixels: Pixels, places: Places | None) -> Pixels:
    """Return an RGB picture with everything outside the surroundings of the marks covered; without marks, all of it."""
    hidden = np.full_like(pixels, COVER)
    if places is None:
        return hidden
    u, v = (sum(place[axis] for place in places) / len(places) for axis in (0, 1))
    around = sorted(places, key=lambda place: math.atan2(place[1] - v, place[0] - u))
    outline = Outline([(u + GROWN * (x - u), v + GROWN * (y - v)) for x, y in around], closed=False)
    rows, columns = pixels.shape[:2]
    across, down = np.meshgrid((np.arange(columns) + 0.5) / columns, (np.arange(rows) + 0.5) / rows)
    inside = outline.contains_points(np.column_stack((across.ravel(), down.ravel()))).reshape(rows, columns, 1)
    return np.where(inside, pixels, hidden)
