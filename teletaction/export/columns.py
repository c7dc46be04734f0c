"""Lays named fields out as columns, for tables: `index.object_c` is the field `object_c` of the index finger."""

import json
from collections.abc import Mapping
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
    return _columns(TOPICS[topic].schema) or {"fields": {"type": "string", "description": "JSON"}}


def row_of(topic: str, fields: Named) -> dict[str, Any]:
    """Return the value of each column; a list of objects is JSON text, an unknown value None."""
    if not TOPICS[topic].schema.get("properties"):
        return {"fields": json.dumps(fields)}
    return _row(TOPICS[topic].schema, fields)


def _columns(schema: Schema, before: str = "") -> dict[str, Schema]:
    found: dict[str, Schema] = {}
    for name, part in schema.get("properties", {}).items():
        if part["type"] == "object":
            found |= _columns(part, f"{before}{name}.")
        else:
            found[before + name] = part
    return found


def _row(schema: Schema, fields: Mapping[str, Any] | None, before: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, part in schema["properties"].items():
        value = None if fields is None else fields.get(name)
        if part["type"] == "object":
            found |= _row(part, value, f"{before}{name}.")
        else:
            found[before + name] = json.dumps(value) if isinstance(value, list) else value
    return found
