"""Groups and counts the rows of the studies."""

from collections.abc import Iterable, Mapping
from typing import Any

from scipy.stats import binomtest

Row = Mapping[str, Any]


def grouped(rows: Iterable[Row], *columns: str) -> dict[tuple[Any, ...], list[Row]]:
    """Return the rows by their values in these columns; groups are in the order of their first rows."""
    found: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        found.setdefault(tuple(row[column] for column in columns), []).append(row)
    return found


def share(hits: int, count: int) -> dict[str, float]:
    """Return a share as a row, with its exact 95 % interval."""
    low, high = binomtest(hits, count).proportion_ci()
    return {"share": hits / count, "low": low, "high": high}
