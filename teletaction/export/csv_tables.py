"""Writes a recording as CSV: one file for each stream, one column for each value."""

import csv
from contextlib import ExitStack
from io import TextIOWrapper
from pathlib import Path

from common.files.private_file import create_private, replacing
from teletaction.export.columns import TIME_COLUMNS, columns_of, row_of, table_name
from teletaction.export.named_recording import NamedRecording


def write_csv(recording: NamedRecording, out: Path) -> dict[str, int]:
    """Write `STREAM.csv` into `out` for each stream, such as `remote-touch.csv`. An unknown value is an empty cell."""
    rows = dict.fromkeys(map(table_name, recording.topics), 0)
    with ExitStack() as files:
        tables = {}
        for topic in recording.topics:
            made = files.enter_context(replacing(out / f"{table_name(topic)}.csv"))
            file = files.enter_context(create_private(made, replace=True))
            text = files.enter_context(TextIOWrapper(file, encoding="utf-8", newline=""))
            tables[topic] = csv.writer(text)
            tables[topic].writerow([*TIME_COLUMNS, *columns_of(topic)])
        for message in recording.messages():
            values = row_of(message.topic, message.fields).values()
            tables[message.topic].writerow([message.wall_ns, message.monotonic_ns, *values])
            rows[table_name(message.topic)] += 1
    return rows
