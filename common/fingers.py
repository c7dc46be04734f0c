"""The five fingers, in the order of every array, packet and frame."""

from typing import Literal

FingerName = Literal["thumb", "index", "middle", "ring", "little"]
FINGERS = ("thumb", "index", "middle", "ring", "little")
"""Index into this tuple is the finger number on the wire."""
FINGER_Y_M = (-0.04, -0.02, 0.0, 0.02, 0.04)
"""Position of each finger across the stroke, relative to the hand's y, m."""


def chosen_fingers(count: int) -> tuple[FingerName, ...]:
    """Return the fingers that a session with `count` fingers uses (1..5).

    A single finger is the index finger, with which people explore.

    Raises:
        ValueError: `count` is not in 1..5.
    """
    if not 1 <= count <= len(FINGERS):
        raise ValueError(f"fingers must be 1..{len(FINGERS)}, not {count}")
    by_use: tuple[FingerName, ...] = ("index", "middle", "thumb", "ring", "little")
    return tuple(sorted(by_use[:count], key=FINGERS.index))
