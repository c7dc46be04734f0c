"""Reads tables of constants that people write; an error names the wrong or missing constant in one line."""

from collections.abc import Mapping
from typing import TypeGuard

from common.files.printable import printable

Range = tuple[float, float]


def read_constants(given: object, ranges: Mapping[str, Range], where: str, *, beside: str = "") -> dict[str, float]:
    """Return the constants of one table of a file.

    Args:
        given: table of a TOML file.
        ranges: minimum and maximum of each constant.
        where: file and table, for the error message.
        beside: one more key that the table may have; it is ignored.

    Raises:
        ValueError: `given` is no table, or a constant is missing, unknown, not a number, or out of range; the message
            names `where` and the constant.
    """
    if not isinstance(given, dict):
        raise ValueError(f"{where} must be a table with {', '.join(ranges)}")
    found = {}
    for constant, (low, high) in ranges.items():
        if constant not in given:
            raise ValueError(f"{where}: {constant} is missing")
        value = given[constant]
        if not within(value, low, high):
            raise ValueError(f"{where}: {constant} must be a number from {low:g} to {high:g}, not {_shown(value)}")
        found[constant] = float(value)
    known = [*ranges, beside] if beside else [*ranges]
    if unknown := sorted(set(given) - set(known)):
        raise ValueError(f"{where}: {unknown[0]} is no constant; there are {', '.join(known)}")
    return found


def within(value: object, low: float, high: float) -> TypeGuard[float]:
    """Return whether `value` is a finite number from `low` to `high`."""
    return isinstance(value, int | float) and not isinstance(value, bool) and low <= value <= high


def _shown(value: object) -> str:
    try:
        return printable(repr(value), 60)
    except (ValueError, RecursionError):  # too many digits, nested too deeply
        return "an unprintable value"
