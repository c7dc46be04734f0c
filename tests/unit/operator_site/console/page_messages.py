"""Reads the binary messages to a page back into what the console encoded."""

import struct

import numpy as np

from common.fingers import FINGERS
from common.wire.packets import LinkState
from operator_site.console.map.map_layer import TILE
from operator_site.console.map.map_tiles import KIND, MapTile
from operator_site.console.map.tactile_map import QUANTITIES
from operator_site.console.state.fingers_now import FIELDS
from operator_site.console.state.frame import (
    CONTACT,
    HEADER,
    IN_USE,
    LIMITED,
    MAGIC,
    PLAYBACK,
    RECORDING,
    VERSION,
    Flags,
    Frame,
    Kind,
    Priority,
)
from operator_site.console.state.signals import SIGNALS

_ROWS = len(FINGERS) * len(FIELDS)
_CELLS = TILE * TILE
BYTES = 12 + 3 * _CELLS


def read_frame(packed: bytes) -> Frame:
    """A picture."""
    magic, version, kind, session, sequence, bits, time_s, _, count, fingers, signals = HEADER.unpack_from(packed)
    assert (magic, version, fingers, signals) == (MAGIC, VERSION, len(FINGERS), len(SIGNALS))

    def five(first: int) -> tuple[bool, ...]:
        return tuple(bool(bits >> (first + finger) & 1) for finger in range(len(FINGERS)))

    states = LinkState(bits & 7), Priority(bits >> 3 & 3), bool(bits & RECORDING), bool(bits & PLAYBACK)
    flags = Flags(*states, five(CONTACT), five(LIMITED), five(IN_USE))
    floats = np.frombuffer(packed, "<f4", offset=HEADER.size)
    rows, bins = floats[:_ROWS].reshape(len(FINGERS), -1), floats[_ROWS:].reshape(count, len(FINGERS) * len(SIGNALS), 2)
    return Frame(sequence, time_s, flags, rows, bins, session, Kind(kind))


def read_tile(message: bytes) -> MapTile:
    """A tile of the map."""
    assert len(message) == BYTES
    magic, version, kind, quantity, column, row, zero, revision = struct.unpack_from("<HBBBBBBI", message)
    assert (magic, version, kind, zero) == (MAGIC, VERSION, KIND, 0)
    value = np.frombuffer(message, "<u2", _CELLS, BYTES - 3 * _CELLS).reshape(TILE, TILE)
    spread = np.frombuffer(message, np.uint8, _CELLS, BYTES - _CELLS).reshape(TILE, TILE)
    return MapTile(QUANTITIES[quantity], column, row, revision, value, spread)
