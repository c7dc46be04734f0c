"""Is what was computed again the same, to the last bit, as what was recorded?"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import msgpack

Fields = Mapping[str, object]


@dataclass(slots=True)
class Comparison:
    """Counts the packets or rows compared, and remembers where they first differ.

    Attributes:
        fields_of: names what stands in a packet or row, to say what differs.
        compared: how many there were.
        identical: how many of them are the same bytes.
        first_difference: tick (from 0), time, field, and its recorded and replayed value.
    """

    fields_of: Callable[[bytes], Fields]
    compared: int = 0
    identical: int = 0
    first_difference: dict[str, object] | None = field(default=None)

    def add(self, tick: int, time_s: float, recorded: bytes, replayed: bytes) -> None:
        """Compare one packet or row of a tick."""
        self.compared += 1
        if recorded == replayed:
            self.identical += 1
        elif self.first_difference is None:
            name, was, now = _difference(self.fields_of(recorded), self.fields_of(replayed))
            self.first_difference = {"tick": tick, "time_s": time_s, "field": name, "recorded": was, "replayed": now}


def _difference(recorded: Fields, replayed: Fields) -> tuple[str, object, object]:
    """Name and both values of the first field that differs, in bits: 0.0 and -0.0 do, two NaN do not."""
    for name, was in recorded.items():
        now = replayed.get(name)
        if msgpack.packb(was) != msgpack.packb(now):
            return name, _presentable(was), _presentable(now)
    return "encoding", None, None


def _presentable(value: object) -> object:
    """A value that JSON can hold."""
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
