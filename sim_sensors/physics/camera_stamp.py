"""A stamp in the simulated camera's picture: its time, and which fingers touch, as light and dark blocks.

With it, pictures can be compared with recorded touch, through camera, codec and network.
"""

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS

Luma = NDArray[np.uint8]
"""Brightness of a picture, (height, width), 0..255."""

_TIME_BITS = 24
_PERIOD_MS = 1 << _TIME_BITS
_PARITY = _TIME_BITS
_FIRST_FINGER = _TIME_BITS + 2
_BLOCKS = 40
"""Number of blocks across the picture; the last ones stay dark."""
_DARK, _LIGHT = 24, 232


def draw_stamp(luma: Luma, time_s: float, contacts: NDArray[np.bool_]) -> None:
    """Draw the stamp into the bottom rows of `luma`, at least 64 by 64; `contacts` (5,) says which fingers touch."""
    time_ms = round(time_s * 1e3) % _PERIOD_MS
    bits = np.zeros(_BLOCKS, dtype=bool)
    bits[:_TIME_BITS] = [time_ms >> bit & 1 for bit in range(_TIME_BITS)]
    bits[_FIRST_FINGER : _FIRST_FINGER + len(FINGERS)] = contacts
    bits[_PARITY] = bits.sum() % 2 == 1
    side = luma.shape[1] // _BLOCKS
    row = np.where(bits, _LIGHT, _DARK).astype(np.uint8).repeat(side)
    luma[-side:, : len(row)] = row


def read_stamp(luma: Luma, near_s: float) -> tuple[float, NDArray[np.bool_]] | None:
    """Return time, s, and contacts (5,) of a picture's stamp; None if it cannot be read.

    `near_s` is within two hours of the picture's time, s, because the stamp repeats.
    """
    side = luma.shape[1] // _BLOCKS
    inner = luma[luma.shape[0] - side :, : side * _BLOCKS].reshape(side, _BLOCKS, side)
    edge = side // 4
    bits = inner[edge : side - edge, :, edge : side - edge].mean(axis=(0, 2)) > 0.5 * (_DARK + _LIGHT)
    parity, bits[_PARITY] = bool(bits[_PARITY]), False
    if bits.sum() % 2 != parity:
        return None
    time_ms = sum(1 << bit for bit in range(_TIME_BITS) if bits[bit])
    near_ms = round(near_s * 1e3)
    half = _PERIOD_MS // 2
    time_ms = near_ms + (time_ms - near_ms + half) % _PERIOD_MS - half
    return time_ms * 1e-3, bits[_FIRST_FINGER : _FIRST_FINGER + len(FINGERS)]
