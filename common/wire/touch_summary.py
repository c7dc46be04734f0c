"""What is told of the object under each finger for a person to read: slowly, beside the numbers that are felt.

It changes at most 1 / TOLD_EVERY_S times a second, so that what was packed or read once serves for many packets.
"""

from functools import lru_cache
from typing import Annotated, Any, NamedTuple

from msgspec import Meta

from common.wire.packets import BadPacket, N, Name, pack, unpack

TOLD_EVERY_S = 0.1
"""Between two changes, s, at least."""
MAX_CANDIDATES = 4
ROUGHNESS_MAX_V = 100.0
GROOVE_MAX_M = 0.1
"""Largest values, and of their standard deviations."""
_Probability = Annotated[float, Meta(ge=0.0, le=1.0)]
_Roughness = Annotated[float, Meta(ge=0.0, le=ROUGHNESS_MAX_V)]
_Groove = Annotated[float, Meta(ge=0.0, le=GROOVE_MAX_M)]


class TouchSummary(NamedTuple):
    """One finger's: materials with their probabilities, 0..1; roughness, V; distance of grooves, m. None: not known.

    `candidates`: at most MAX_CANDIDATES, likeliest first; what is missing to 1 is anything else.
    """

    candidates: Annotated[tuple[tuple[Name, _Probability], ...], Meta(max_length=MAX_CANDIDATES)] = ()
    roughness_v: _Roughness | None = None
    roughness_sd_v: _Roughness | None = None
    groove_m: _Groove | None = None
    groove_sd_m: _Groove | None = None


NOTHING = TouchSummary()
NOTHING_TOLD = (NOTHING,) * N
"""Of all fingers."""
_AllTold = Annotated[tuple[TouchSummary, ...], Meta(min_length=N, max_length=N)]


@lru_cache(maxsize=64)
def pack_told(told: tuple[TouchSummary, ...]) -> bytes:
    """Bytes of all fingers' within a packet; raises BadPacket on what the far side would refuse."""
    packed = pack(told)
    read_told(packed)
    return packed


@lru_cache(maxsize=64)
def read_told(packed: bytes) -> tuple[TouchSummary, ...]:
    """What these bytes within a packet tell of each finger; raises BadPacket."""
    told = unpack(packed, _AllTold, "told")
    # The decoder takes integers for floats, and a list that ends early for one with default values.
    for fields in unpack(packed, list[list[Any]], "told"):
        if len(fields) != len(TouchSummary._fields) or int in map(
            type, (*fields[1:], *(number for _, number in fields[0]))
        ):
            raise BadPacket(f"told: not {len(TouchSummary._fields)} fields of a finger, with numbers that are floats")
    return told
