"""Broken frames, cheap to make: every other one grown from good ones, the rest random; the same in every run."""

import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

import msgpack

Mutation = Callable[[bytes, Random], bytes]

NUMBERS: tuple[bytes, ...] = (
    *(struct.pack("<f", value) for value in (float("nan"), float("inf"), -float("inf"), 1e-45, -1e-40, 3.4e38, -0.0)),
    *(struct.pack("<d", value) for value in (float("nan"), float("inf"), 5e-324, 1.8e308)),
    *(struct.pack(">d", value) for value in (float("nan"), -float("inf"), 5e-324, 1.8e308)),
    *(bytes((fill,)) * size for fill in (0x00, 0x01, 0x7F, 0x80, 0xFF) for size in (1, 2, 4, 8)),
)
"""Bytes of numbers at the ends of what their types can hold, or of none at all."""

VALUES: tuple[bytes, ...] = (
    *map(msgpack.packb, (None, True, 0, -1, 0.0, -0.0, "", "x" * 41, "\0", b"", [], {}, [[]], {"a": []})),
    *map(msgpack.packb, (2**63 - 1, 2**63, 2**64 - 1, -(2**63), float("nan"), float("inf"), 5e-324)),
    *map(msgpack.packb, ([None] * 40, {str(n): n for n in range(40)}, "x" * 400, bytes(380), bytes(60))),
    *map(msgpack.packb, ([None] * 3500, {str(n): [n] for n in range(500)}, "x" * 3500)),
    *(msgpack.packb(value, use_single_float=True) for value in (float("nan"), 1e-45, -float("inf"), 1.5)),
    *(nest * depth + b"\xc0" for nest in (b"\x91", b"\x81\xa1a", b"\x81") for depth in (3, 400, 600, 1100)),
    msgpack.packb(msgpack.ExtType(5, b"12345678")),
    msgpack.packb(msgpack.Timestamp(2**60, 999_999_999)),
    b"\xd7\xff" + b"\xff" * 8,  # a time stamp of more than 10^9 ns
    b"\xc7\x00\xff",  # a time stamp of no bytes
    b"\xc1",  # the one code that MessagePack never uses
    b"\xa2\xff\xfe",  # a text that is no UTF-8
    b"\xa3\xed\xa0\x80",  # half a surrogate pair as a text
    b"\x81\x01\x01",  # a map whose key is a number
    b"\x81\xc4\x01a\x01",  # ... or bytes
    b"\x82\xa1a\x01\xa1a\x02",  # ... or there twice
    *(code + b"\xff\xff\xff\xff" for code in (b"\xc6", b"\xc9", b"\xdb", b"\xdd", b"\xdf")),  # 4 GB are announced
)
"""MessagePack values that the schema promises nowhere, or not there."""


def flip_bits(frame: bytes, rng: Random) -> bytes:
    """One to eight wrong bits."""
    broken = bytearray(frame)
    for _ in range(1 + rng.getrandbits(3)):
        broken[int(rng.random() * len(broken))] ^= 1 << rng.getrandbits(3)
    return bytes(broken)


def truncate(frame: bytes, rng: Random) -> bytes:
    """The frame's beginning."""
    return frame[: int(rng.random() * len(frame))]


def insert(frame: bytes, rng: Random) -> bytes:
    """Up to eight bytes too many."""
    at = int(rng.random() * (len(frame) + 1))
    return frame[:at] + rng.randbytes(1 + rng.getrandbits(3)) + frame[at:]


def delete(frame: bytes, rng: Random) -> bytes:
    """Up to eight bytes missing inside."""
    at = int(rng.random() * len(frame))
    return frame[:at] + frame[at + 1 + rng.getrandbits(3) :]


def repeat(frame: bytes, rng: Random) -> bytes:
    """A piece of it twice."""
    start, end = int(rng.random() * len(frame)), int(rng.random() * len(frame))
    return frame[:end] + frame[start:]


def put_number(frame: bytes, rng: Random) -> bytes:
    """An extreme number written over something; the length stays."""
    number = NUMBERS[int(rng.random() * len(NUMBERS))]
    at = int(rng.random() * max(1, len(frame) - len(number) + 1))
    return (frame[:at] + number + frame[at + len(number) :])[: len(frame)]


def splice_of(frames: Sequence[bytes]) -> Mutation:
    """The beginning of one frame and the end of another."""

    def splice(frame: bytes, rng: Random) -> bytes:
        other = frames[int(rng.random() * len(frames))]
        return frame[: int(rng.random() * (len(frame) + 1))] + other[int(rng.random() * (len(other) + 1)) :]

    return splice


def swap_values_of(packets: Sequence[bytes]) -> Mutation:
    """Another MessagePack value, or another type or length, in any place of a packet, at any depth."""
    spans = [(packet, start, end) for packet in packets for start, end in value_spans(packet)]
    whole = [(packet[:start], packet[end:]) for packet, start, end in spans]
    heads = [(packet[:start], packet[start + 1 :]) for packet, start, _ in spans]

    def swap(_: bytes, rng: Random) -> bytes:
        if rng.random() < 0.7:
            before, after = whole[int(rng.random() * len(whole))]
            return before + VALUES[int(rng.random() * len(VALUES))] + after
        before, after = heads[int(rng.random() * len(heads))]
        return before + bytes((rng.getrandbits(8),)) + after

    return swap


def value_spans(packet: bytes) -> list[tuple[int, int]]:
    """Where each value of a good packet begins and ends, those inside lists and maps too."""
    unpacker = msgpack.Unpacker()
    unpacker.feed(packet)
    spans: list[tuple[int, int]] = []

    def walk(value: Any) -> None:
        start = unpacker.tell()
        if isinstance(value, list):
            unpacker.read_array_header()
            for item in value:
                walk(item)
        elif isinstance(value, dict):
            unpacker.read_map_header()
            for pair in value.items():
                for item in pair:
                    walk(item)
        else:
            unpacker.skip()
        spans.append((start, unpacker.tell()))

    walk(msgpack.unpackb(packet))
    return spans


@dataclass(frozen=True, slots=True)
class Breaker:
    """Makes broken frames of good ones.

    Attributes:
        good: what the decoder takes.
        longest: of a random frame, bytes; every other one has the length of a good one.
        mutations: besides those that every codec gets.
        mend: makes a broken frame's check sum good again, so that what stands behind it is reached; of every other one.
        seed: another one gives other frames.
    """

    good: Sequence[bytes]
    longest: int
    mutations: Sequence[Mutation] = ()
    mend: Callable[[bytes], bytes] | None = None
    seed: int = 20_030_322

    def frames(self, count: int) -> Iterator[bytes]:
        """`count` frames, mutated and random by turns."""
        rng = Random(self.seed)
        mutations = (
            *(flip_bits, truncate, insert, delete, repeat, put_number, splice_of(self.good)),
            *self.mutations,
        )
        for number in range(count):
            good = self.good[int(rng.random() * len(self.good))]
            if number % 2:
                frame = rng.randbytes(len(good) if number % 4 == 1 else int(rng.random() * self.longest))
            else:
                frame = mutations[int(rng.random() * len(mutations))](good, rng)
                if frame and not rng.getrandbits(3):
                    frame = mutations[int(rng.random() * len(mutations))](frame, rng)
            yield self.mend(frame) if self.mend is not None and rng.getrandbits(1) else frame
