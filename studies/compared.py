"""The numbers by which two runs of a study are compared: where they stand, what is better, what is no difference."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

Better = Literal["less", "more", "same"]
CHANCE_SDS = 3.0
"""Two shares of so many draws may differ by this many standard deviations of their difference."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number of one run.

    Attributes:
        value: None where there is none.
        count: draws that it is a share of; None: it is no share.
    """

    value: float | None
    count: float | None = None


@dataclass(frozen=True, slots=True)
class Compared:
    """A column of a study's data.

    Attributes:
        table: its rows in the data, keys joined by dots; what is no list is one row, "" the data itself.
        value: the column; true counts as 1.
        better: which way.
        by: columns that tell the rows apart.
        only: rows with these values; others are not compared.
        absolute, relative: may differ by so much, in the number's own unit and as a share of the old one.
        counted: column with the number of draws that the value is a share of; what chance does may differ as well.
    """

    table: str
    value: str
    better: Better
    by: tuple[str, ...] = ()
    only: Mapping[str, Any] = field(default_factory=dict)
    absolute: float = 0.0
    relative: float = 0.0
    counted: str | None = None

    def numbers(self, data: Mapping[str, Any]) -> dict[str, Number]:
        """What a run has, by name.

        Raises:
            ValueError: `by` does not tell the rows apart.
        """
        found: dict[str, Number] = {}
        for row in self._rows(data):
            which = [f"{column}={row.get(column)}" for column in self.by]
            name = " ".join(filter(None, (self.table, self.value, ", ".join(which))))
            if name in found:
                raise ValueError(f"{name}: several rows of one name")
            count = None if self.counted is None else _number(row.get(self.counted))
            found[name] = Number(_number(row.get(self.value)), count)
        return found

    def may_differ(self, old: Number, new: Number) -> float:
        """How far apart two numbers may be and still be one."""
        assert old.value is not None
        assert new.value is not None
        allowed = self.absolute + self.relative * abs(old.value)
        if not (old.count and new.count):
            return allowed
        draws = old.count + new.count
        # One more of each kind: where none of few failed, one of the next might.
        share = (old.value * old.count + new.value * new.count + 1.0) / (draws + 2.0)
        chance = max(0.0, share * (1.0 - share)) * (1.0 / old.count + 1.0 / new.count)
        return allowed + CHANCE_SDS * math.sqrt(chance)

    def worse_by(self, old: Number, new: Number) -> float:
        """How much worse the new number is, negative where it is better."""
        assert old.value is not None
        assert new.value is not None
        more = new.value - old.value
        return {"less": more, "more": -more, "same": abs(more)}[self.better]

    def _rows(self, data: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        found: Any = data
        for key in filter(None, self.table.split(".")):
            found = found.get(key) if isinstance(found, Mapping) else None
        rows: Sequence[Any] = found if isinstance(found, list) else [found]
        for row in rows:
            if isinstance(row, Mapping) and all(row.get(key) == value for key, value in self.only.items()):
                yield row


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None
