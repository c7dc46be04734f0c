"""Numbers by which two runs of a study are compared: place in the data, direction of improvement, tolerance."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

Better = Literal["less", "more", "same"]
CHANCE_SDS = 3.0
"""Allowed difference of two sampled shares, in standard deviations of that difference."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number of one run.

    Attributes:
        value: the number; None where it is missing.
        count: number of draws behind a share; None: the value is not a share.
    """

    value: float | None
    count: float | None = None


@dataclass(frozen=True, slots=True)
class Compared:
    """A column of a study's data.

    Attributes:
        table: path of the rows in the data, keys joined by dots; "" is the data itself. Anything but a list is one row.
        value: the column; true counts as 1.
        better: direction of improvement.
        by: columns that distinguish the rows.
        only: values that a row must have to be compared.
        absolute, relative: tolerance in the number's own unit, and as a share of the old number.
        counted: column with the number of draws behind a share; sampling noise then adds to the tolerance.
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
        """Numbers of a run by name; raises ValueError where `by` does not distinguish the rows."""
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
        """Largest difference at which two numbers count as the same."""
        assert old.value is not None
        assert new.value is not None
        allowed = self.absolute + self.relative * abs(old.value)
        if not (old.count and new.count):
            return allowed
        draws = old.count + new.count
        # Rule of succession, one success and one failure added: few draws without a failure do not prove a rate of 0.
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
