"""What is told of the object under each finger for a person to read: slowly, beside the numbers that are felt.

It changes at most 1 / TOLD_EVERY_S times a second, so that what was packed or read once serves for many packets.
"""

from functools import lru_cache
from typing import NamedTuple

from common.packets import BadPacket, N, pack, read_text, unpack_list

TOLD_EVERY_S = 0.1
"""Between two changes, s, at least."""
MAX_CANDIDATES = 4
ROUGHNESS_MAX_V = 100.0
GROOVE_MAX_M = 0.1
"""Largest values, and of their standard deviations."""
_HIGH = (ROUGHNESS_MAX_V, ROUGHNESS_MAX_V, GROOVE_MAX_M, GROOVE_MAX_M)
_NUMBERS = ("roughness_v", "roughness_sd_v", "groove_m", "groove_sd_m")


class Told(NamedTuple):
    """One finger's: materials with their probabilities, 0..1; roughness, V; distance of grooves, m. None: not known.

    `candidates`: at most MAX_CANDIDATES, likeliest first; what is missing to 1 is anything else.
    """

    candidates: tuple[tuple[str, float], ...] = ()
    roughness_v: float | None = None
    roughness_sd_v: float | None = None
    groove_m: float | None = None
    groove_sd_m: float | None = None


NOTHING = Told()
NOTHING_TOLD = (NOTHING,) * N
"""Of all fingers."""


@lru_cache(maxsize=64)
def pack_told(told: tuple[Told, ...]) -> bytes:
    """Bytes of all fingers' within a packet; raises BadPacket on what the far side would refuse."""
    packed = pack([[one.candidates, *one[1:]] for one in told])
    read_told(packed)
    return packed


@lru_cache(maxsize=64)
def read_told(packed: bytes) -> tuple[Told, ...]:
    """What these bytes within a packet tell of each finger; raises BadPacket."""
    fingers = unpack_list(packed)
    if len(fingers) != N:
        raise BadPacket(f"told: {len(fingers)} fingers, expected {N}")
    return tuple([_read(finger) for finger in fingers])


def _read(finger: object) -> Told:
    if type(finger) is not list or len(finger) != 1 + len(_NUMBERS):
        raise BadPacket(f"told: not a list of {1 + len(_NUMBERS)} fields")
    candidates, *numbers = finger
    if type(candidates) is not list or len(candidates) > MAX_CANDIDATES:
        raise BadPacket(f"told: candidates are not a list of at most {MAX_CANDIDATES}")
    for value, high, name in zip(numbers, _HIGH, _NUMBERS, strict=True):
        if value is not None and (type(value) is not float or not 0.0 <= value <= high):
            raise BadPacket(f"told: {name} is neither nil nor a number in 0..{high:g}")
    return Told(tuple([_candidate(candidate) for candidate in candidates]), *numbers)


def _candidate(candidate: object) -> tuple[str, float]:
    if type(candidate) is not list or len(candidate) != 2:
        raise BadPacket("told: a candidate is not a name and a probability")
    name, probability = candidate
    if type(probability) is not float or not 0.0 <= probability <= 1.0:
        raise BadPacket("told: a probability is not a number in 0..1")
    return read_text(name, "told: candidate"), probability
