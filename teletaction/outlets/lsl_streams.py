"""Serves live messages as LSL streams, with the names and units of the export's columns."""

import math
from collections.abc import Sequence
from typing import Any

from teletaction.export.columns import columns_of, row_of
from teletaction.export.log_entries import log_entry
from teletaction.export.named_fields import Schema
from teletaction.export.named_recording import NamedMessage
from teletaction.outlets.live_messages import FED_TOPICS
from teletaction.outlets.place import Place

try:
    import pylsl
except RuntimeError:  # pylsl is there, the library that it needs is not
    raise ValueError("needs liblsl, the library of LSL: install it, or name its file in PYLSL_LIB") from None

NUMBERS = ("number", "integer", "boolean")
"""Types of a column that is sent as a number."""
BUFFER = 60
"""Samples that wait for one client, in hundreds, about twelve seconds; for a slower one the oldest are dropped."""


class LslStreams:
    """LSL outlets: numbers of a stream as `operator/touch`, its texts as `operator/touch/text`, and markers as `log`.

    Time stamps are of this machine's monotonic clock, which is LSL's clock.

    Attributes:
        address: begin of the source identifier of each stream.
    """

    def __init__(self, place: Place):
        """Announce the streams."""
        self.address = place.site
        self._streams = {topic: _streams(place.site, topic) for topic in FED_TOPICS}
        self._streams["log"] = [_Stream(place.site, "log", "Markers", {"message": {"type": "string"}})]

    def offer(self, messages: Sequence[NamedMessage]) -> None:
        """Push a sample of each message."""
        for message in messages:
            self._push(message.topic, message, row_of(message.topic, message.fields))
            if (entry := log_entry(message)) is not None:
                self._push("log", message, {"message": f"{message.topic}: {entry['message']}"})

    def close(self) -> None:
        """End the streams."""
        self._streams.clear()

    def _push(self, name: str, message: NamedMessage, row: dict[str, Any]) -> None:
        for stream in self._streams[name]:
            stream.push(message.monotonic_ns * 1e-9, row)


class _Stream:
    """One LSL outlet with the channels `columns`, all of them numbers or all of them texts."""

    def __init__(self, site: str, name: str, kind: str, columns: dict[str, Schema]):
        self._text = {schema["type"] for schema in columns.values()}.isdisjoint(NUMBERS)
        self._columns = tuple(columns)
        info = pylsl.StreamInfo(
            name,
            kind,
            len(columns),
            pylsl.IRREGULAR_RATE,
            pylsl.cf_string if self._text else pylsl.cf_double64,
            f"{site} {name}",
        )
        info.set_channel_labels(list(columns))
        info.set_channel_units([schema.get("unit", "none") for schema in columns.values()])
        self._outlet = pylsl.StreamOutlet(info, max_buffered=BUFFER)

    def push(self, time_s: float, row: dict[str, Any]) -> None:
        """Push one sample; an unknown number is NaN, an unknown text empty."""
        values = [row[name] for name in self._columns]
        sample = (
            ["" if text is None else str(text) for text in values]
            if self._text
            else [math.nan if number is None else float(number) for number in values]
        )
        self._outlet.push_sample(sample, time_s)


def _streams(site: str, topic: str) -> list[_Stream]:
    columns = columns_of(topic)
    numbers = {name: schema for name, schema in columns.items() if schema["type"] in NUMBERS}
    texts = {name: schema for name, schema in columns.items() if name not in numbers}
    named = ((topic, numbers), (f"{topic}/text", texts))
    return [_Stream(site, name, "teletaction", chosen) for name, chosen in named if chosen]
