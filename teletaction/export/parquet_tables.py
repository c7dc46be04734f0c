"""Writes a recording as Parquet: one file for each stream, one typed column with its unit for each value."""

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow.parquet import ParquetWriter

from common.files.private_file import create_private, replacing
from teletaction.export.columns import TIME_COLUMNS, columns_of, row_of, table_name
from teletaction.export.named_fields import Schema
from teletaction.export.named_recording import NamedRecording

_TYPES = {"number": pa.float64(), "integer": pa.int64(), "boolean": pa.bool_(), "string": pa.string()}
_GROUP = 20_000
"""Number of rows that are written at once; limits the memory for a long session."""


def write_parquet(recording: NamedRecording, out: Path) -> dict[str, int]:
    """Write `STREAM.parquet` into `out` for each stream, such as `remote-touch.parquet`. An unknown value is null."""
    with ExitStack() as files:
        tables = {}
        for topic in recording.topics:
            made = files.enter_context(replacing(out / f"{table_name(topic)}.parquet"))
            file = files.enter_context(create_private(made, replace=True))
            tables[topic] = files.enter_context(_Table(file, topic))
        for message in recording.messages():
            row = dict(zip(TIME_COLUMNS, (message.wall_ns, message.monotonic_ns), strict=True))
            tables[message.topic].add(row | row_of(message.topic, message.fields))
    return {table_name(topic): table.rows for topic, table in tables.items()}


class _Table:
    """One file; rows are written in groups."""

    def __init__(self, file: Any, topic: str):
        self.rows = 0
        self._schema = pa.schema(
            [pa.field("wall_ns", pa.timestamp("ns", "UTC"), False), pa.field("monotonic_ns", pa.int64(), False)]
            + [_field(name, schema) for name, schema in columns_of(topic).items()]
        )
        self._writer = ParquetWriter(file, self._schema, compression="zstd")
        self._waiting: list[dict[str, Any]] = []

    def add(self, row: dict[str, Any]) -> None:
        self._waiting.append(row)
        self.rows += 1
        if len(self._waiting) >= _GROUP:
            self._write()

    def __enter__(self) -> "_Table":
        return self

    def __exit__(self, *_: object) -> None:
        self._write()
        self._writer.close()

    def _write(self) -> None:
        self._writer.write_table(pa.Table.from_pylist(self._waiting, self._schema))
        self._waiting.clear()


def _field(name: str, schema: Schema) -> pa.Field:
    return pa.field(name, _TYPES.get(schema["type"], pa.string()), metadata={"unit": schema.get("unit", "")})
