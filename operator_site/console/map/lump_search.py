"""Searches the growing map of a session for lumps and for the next place to press."""

from typing import Any, NamedTuple

from operator_site.console.map.lump_areas import Floats, field_of, lumps_of, next_press_mm


class Searched(NamedTuple):
    """Result of a search: lumps, see `lump_areas.lumps_in`, and the next place to press, mm, None if unknown."""

    lumps: list[dict[str, Any]]
    next_mm: tuple[float, float] | None


NOTHING = Searched([], None)


def search_lumps(rows: Floats) -> Searched:
    """Search the presses of a map, `StiffnessLayer.rows`. Raises ValueError for rows that are none."""
    field = field_of(rows)
    return NOTHING if field is None else Searched(lumps_of(field), next_press_mm(field))
