"""Summary of the object under each finger, as text and numbers for a person to read.

It changes at most every SUMMARY_INTERVAL_S, so that one packing or reading serves for many packets.
"""

from functools import lru_cache
from typing import Annotated, Any, NamedTuple

from msgspec import Meta

from common.wire.packets import BadPacket, N, Name, pack, unpack

SUMMARY_INTERVAL_S = 0.1
"""Minimum time between two changes of the summary, s."""
MAX_CANDIDATES = 4
"""Maximum number of materials in the summary of a finger."""
ROUGHNESS_MAX_V = 100.0
"""Maximum roughness, and maximum of its standard deviation, V."""
GROOVE_MAX_M = 0.1
"""Maximum distance of grooves, and maximum of its standard deviation, m."""
_Probability = Annotated[float, Meta(ge=0.0, le=1.0)]
_Roughness = Annotated[float, Meta(ge=0.0, le=ROUGHNESS_MAX_V)]
_Groove = Annotated[float, Meta(ge=0.0, le=GROOVE_MAX_M)]


class TouchSummary(NamedTuple):
    """Summary of one finger: materials with probabilities, 0..1; roughness, V; groove distance, m. None: unknown.

    `candidates` has at most MAX_CANDIDATES, likeliest first; the rest to 1 is the probability of any other material.
    """

    candidates: Annotated[tuple[tuple[Name, _Probability], ...], Meta(max_length=MAX_CANDIDATES)] = ()
    roughness_v: _Roughness | None = None
    roughness_sd_v: _Roughness | None = None
    groove_m: _Groove | None = None
    groove_sd_m: _Groove | None = None


NOTHING = TouchSummary()
NO_SUMMARIES = (NOTHING,) * N
"""Empty summary of all fingers."""
_AllSummaries = Annotated[tuple[TouchSummary, ...], Meta(min_length=N, max_length=N)]


@lru_cache(maxsize=64)
def pack_summaries(summaries: tuple[TouchSummary, ...]) -> bytes:
    """Return the bytes of all fingers' summaries for a packet; raises BadPacket if the far side would refuse them."""
    packed = pack(summaries)
    read_summaries(packed)
    return packed


@lru_cache(maxsize=64)
def read_summaries(packed: bytes) -> tuple[TouchSummary, ...]:
    """Return the summary of each finger from its bytes in a packet; raises BadPacket."""
    summaries = unpack(packed, _AllSummaries, "summaries")
    # The decoder takes integers for floats, and a short list for one with default values.
    for fields in unpack(packed, list[list[Any]], "summaries"):
        if len(fields) != len(TouchSummary._fields) or int in map(
            type, (*fields[1:], *(number for _, number in fields[0]))
        ):
            raise BadPacket(
                f"summaries: not {len(TouchSummary._fields)} fields of a finger, with numbers that are floats"
            )
    return summaries
