"""Compares replayed packets and rows with the recorded ones, bit by bit."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import msgpack

Fields = Mapping[str, object]


@dataclass(slots=True)
class Comparison:
    """Counts the packets or rows compared and keeps their first difference.

    Attributes:
        fields_of: decodes a packet or row into named fields.
        compared: number of packets or rows compared.
        identical: number of those with the same bytes.
        first_difference: tick (from 0), time (s), field, recorded and replayed value; None without a difference.
    """

    fields_of: Callable[[bytes], Fields]
    compared: int = 0
    identical: int = 0
    first_difference: dict[str, object] | None = None

    def add(self, tick: int, time_s: float, recorded: bytes, replayed: bytes) -> None:
        """Compare one packet or row of a tick at `time_s` (s)."""
        self.compared += 1
        if recorded == replayed:
            self.identical += 1
        elif self.first_difference is None:
            name, was, now = _difference(self.fields_of(recorded), self.fields_of(replayed))
            self.first_difference = {"tick": tick, "time_s": time_s, "field": name, "recorded": was, "replayed": now}


def _difference(recorded: Fields, replayed: Fields) -> tuple[str, object, object]:
    """Return name and both values of the first field that differs in bits: 0.0 and -0.0 differ, two NaN do not."""
    for name, was in recorded.items():
        now = replayed.get(name)
        if msgpack.packb(was) != msgpack.packb(now):
            return name, _presentable(was), _presentable(now)
    return "encoding", None, None


def _presentable(value: object) -> object:
    """Convert a value to one that JSON can hold."""
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
