"""Lays named fields out as columns, for tables: `index.object_c` is the field `object_c` of the index finger."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from teletaction.export.named_fields import Named, Schema
from teletaction.export.topics import TOPICS

TIME_COLUMNS = ("wall_ns", "monotonic_ns")
"""First columns of each table: ns since 1970 (UTC), and ns of the recording machine's monotonic clock."""


def table_name(topic: str) -> str:
    """Return the name of a stream's table, such as `remote-touch` of `remote/touch`."""
    return topic.replace("/", "-")


def columns_of(topic: str) -> dict[str, Schema]:
    """Return the schema of each column of a stream. One without fixed fields has a column `fields` with JSON."""
    columns = {name: part for name, part, _ in _leaves(TOPICS[topic].schema, None)}
    return columns or {"fields": {"type": "string", "description": "JSON"}}


def row_of(topic: str, fields: Named) -> dict[str, Any]:
    """Return the value of each column; a list of objects is JSON text, an unknown value None."""
    schema = TOPICS[topic].schema
    if not schema.get("properties"):
        return {"fields": json.dumps(fields)}
    leaves = _leaves(schema, fields)
    return {name: json.dumps(value) if isinstance(value, list) else value for name, _, value in leaves}


def _leaves(schema: Schema, fields: Mapping[str, Any] | None, before: str = "") -> Iterator[tuple[str, Schema, Any]]:
    """Yield column, schema and value of each part that is no object."""
    for name, part in schema.get("properties", {}).items():
        value = None if fields is None else fields.get(name)
        if part["type"] == "object":
            yield from _leaves(part, value, f"{before}{name}.")
        else:
            yield before + name, part, value
