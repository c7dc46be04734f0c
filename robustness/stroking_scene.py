"""Writes the scene of the sessions with injected faults: a finger strokes one rough object to and fro."""

from pathlib import Path

_OBJECT = """
name = "stroking"
calibrated = ["pine"]
[[objects]]
name = "rough"
material = "cardboard"
surface = "sandpaper"
x_m = 0.0
length_m = 0.30
"""
_UNDER_THE_MIDDLE_FINGER = """
y_m = -0.02
width_m = 0.016
"""
_TOUCH = """
[[script]]
act = "move"
object = "rough"
u = {}
[[script]]
act = "touch"
"""
_STROKE = """
[[script]]
act = "stroke"
to_object = "rough"
u = {}
speed_mm_s = 50.0
"""
_LIFT = """
[[script]]
act = "lift"
"""


def write_stroking_scene(folder: Path, *places: float, lift: bool = True, narrow: bool = False) -> Path:
    """Write the scene into a folder, under the name of the table that identifies its material.

    Args:
        folder: existing folder.
        places: places along the object, 0..1: the touched place, then the end of each stroke at 50 mm/s.
        lift: whether the finger leaves the object at the end, before the script repeats.
        narrow: whether the object is under the middle finger only. The heater of the index finger's sensor then stays
            on.

    Returns:
        The scene's file.
    """
    first, *others = places
    across = _UNDER_THE_MIDDLE_FINGER if narrow else ""
    script = _TOUCH.format(first) + "".join(_STROKE.format(place) for place in others) + (_LIFT if lift else "")
    scene = folder / "materials.toml"
    scene.write_text(_OBJECT + across + script, "utf-8")
    return scene
