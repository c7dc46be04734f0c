"""A recorded session for Python programs: streams with named columns, arrays and data frames."""

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.privacy.recording_file import open_recording
from teletaction.export.columns import columns_of, row_of
from teletaction.export.named_recording import NamedRecording

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[Any]


class Stream:
    """The messages of one recorded stream: n times, and n values in each column.

    Attributes:
        name: stream, such as `remote/touch`.
        wall_ns: times, (n,), ns since 1970 (UTC).
        time_s: times, (n,), s since the recording began.
        columns: names of the columns; `index.object_c` is the object's temperature under the index finger.
    """

    def __init__(self, name: str, wall_ns: Array, time_s: Array, values: dict[str, Array], units: dict[str, str]):
        """Hold the arrays; `Recording` makes them."""
        self.name, self.wall_ns, self.time_s = name, wall_ns, time_s
        self._values, self._units = values, units

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        return f"<Stream {self.name}: {len(self)} messages, {len(self._values)} columns>"

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self._values)

    def unit(self, column: str) -> str:
        """Return the unit of a column, such as `N/m`; empty for one without a unit.

        Raises:
            KeyError: there is no such column.
        """
        self.array(column)
        return self._units[column]

    def array(self, column: str) -> Array:
        """Return the values of a column, (n,): float64 with NaN for unknown numbers, or text with None.

        A whole number above 2^53, such as the session's, is rounded. An export has all its digits.

        Raises:
            KeyError: there is no such column; the message lists those there are.
        """
        if column not in self._values:
            raise KeyError(f"{self.name}: no column {column!r}; there are {', '.join(self._values)}")
        return self._values[column]

    def __getitem__(self, finger: str) -> "Stream":
        """Return the columns of one finger, without the finger's name: `touch["index"].array("object_c")`.

        Raises:
            KeyError: there is no such finger, or the stream has no values of fingers.
        """
        before = f"{finger}."
        named = [name for name in self._values if name.startswith(before)]
        if finger not in FINGERS or not named:
            raise KeyError(f"{self.name}: no finger {finger!r}; fingers are {', '.join(FINGERS)}")
        values = {name.removeprefix(before): self._values[name] for name in named}
        units = {name.removeprefix(before): self._units[name] for name in named}
        return Stream(f"{self.name} {finger}", self.wall_ns, self.time_s, values, units)

    def to_pandas(self) -> "DataFrame":
        """Return a data frame whose index is the wall-clock time.

        Raises:
            ModuleNotFoundError: pandas is not installed.
        """
        import pandas as pd  # noqa: PLC0415 - an optional package

        index = pd.DatetimeIndex(self.wall_ns.view("datetime64[ns]"), tz="UTC", name="time")
        return pd.DataFrame(self._values, index=index)


class Recording:
    """A whole recording of a session. Streams are read on first use.

    Attributes:
        path: path of the file.
        streams: names of the streams that have messages.
        began: wall-clock time of the first message.
    """

    def __init__(self, path: Path | str, began: datetime | None = None):
        """Open a recording of one site, or a merged `session.mcap`.

        Args:
            path: path of the file.
            began: time of the first message; needed for a recording of version 0.1.0.

        Raises:
            OSError: the file cannot be read.
            ValueError: it is no whole recording, or has no wall-clock time and `began` is missing.
        """
        self.path = Path(path)
        with open_recording(self.path) as file:
            named = NamedRecording(self.path, file, began)
        self.streams = tuple(named.topics)
        self.began = datetime.fromtimestamp(named.begin_ns * 1e-9).astimezone()
        self._given = began
        self._read: dict[str, Stream] = {}

    def __repr__(self) -> str:
        return f"<Recording {self.path}: {', '.join(self.streams)}>"

    def __getitem__(self, stream: str) -> Stream:
        """Return a stream by its name, such as `operator/rendered`.

        Raises:
            KeyError: the recording has no such stream; the message lists those there are.
            OSError: the file cannot be read any more.
            ValueError: the stream is damaged.
        """
        if stream not in self.streams:
            raise KeyError(f"{self.path}: no stream {stream!r}; there are {', '.join(self.streams)}")
        if stream not in self._read:
            self._load([stream])
        return self._read[stream]

    def read(self) -> None:
        """Read all streams now, so that the file is no longer needed. The file is checked and read once.

        Raises:
            OSError: the file cannot be read.
            ValueError: a stream is damaged.
        """
        if missing := [stream for stream in self.streams if stream not in self._read]:
            self._load(missing)

    def _load(self, streams: list[str]) -> None:
        with open_recording(self.path) as file:
            self._read |= _streams(NamedRecording(self.path, file, self._given), streams)

    @property
    def touch(self) -> Stream:
        """What the remote fingers touch, as the remote site sent it."""
        return self["remote/touch"]

    @property
    def motion(self) -> Stream:
        """Where the operator's fingertips were, as the operator's site sent it."""
        return self["operator/motion"]

    @property
    def rendered(self) -> Stream:
        """Force, motor speed and plate temperature that left the operator's gate for the fingers."""
        return self["operator/rendered"]


def _streams(recording: NamedRecording, topics: list[str]) -> dict[str, Stream]:
    """Read streams in one pass over the file."""
    times: dict[str, list[int]] = {topic: [] for topic in topics}
    rows: dict[str, list[tuple[Any, ...]]] = {topic: [] for topic in topics}
    for message in recording.messages(topics):
        times[message.topic].append(message.wall_ns)
        rows[message.topic].append(tuple(row_of(message.topic, message.fields).values()))
    return {topic: _stream(topic, recording.begin_ns, times.pop(topic), rows.pop(topic)) for topic in topics}


def _stream(topic: str, begin_ns: int, times: list[int], rows: list[tuple[Any, ...]]) -> Stream:
    schema = columns_of(topic)
    wall_ns = np.array(times, dtype=np.int64)
    values = {
        name: _array(column, schema[name]["type"]) for name, column in zip(schema, zip(*rows, strict=True), strict=True)
    }
    units = {name: each.get("unit", "") for name, each in schema.items()}
    return Stream(topic, wall_ns, (wall_ns - begin_ns) * 1e-9, values, units)


def _array(values: tuple[Any, ...], kind: str) -> Array:
    if kind in ("number", "integer", "boolean"):
        return np.array(values, dtype=np.float64)  # None becomes NaN
    return np.array(values, dtype=np.object_)
