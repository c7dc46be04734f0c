"""A whole recording opened for replay: its messages, and what each site was configured and calibrated with."""

import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, TypeVar

from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC

from common.cut_recording import is_whole
from remote_site.stored_table import StoredTable
from teletaction.merge import ORIGIN

Table = TypeVar("Table", bound=StoredTable)


class RecordedSession:
    """One site's recording, or several merged; in a merged one, each has its own configuration and tables.

    A recording is known by its origin: the name it had before merging, empty for a single one.
    """

    def __init__(self, path: Path, file: IO[bytes]):
        """Open `file`, found at `path`.

        Raises:
            ValueError: it is no MCAP file, or one without its end.
        """
        if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            raise ValueError(f"{path}: not an MCAP file")
        if not is_whole(file):
            raise ValueError(f"{path}: cut, without its end; `teletaction recover {path}` makes a whole one of it")
        self.path = path
        self.reader = make_reader(file)
        summary = self.reader.get_summary()
        if summary is None or summary.statistics is None:
            raise ValueError(f"{path}: its index has no statistics: not a recording of this program")
        self.start_ns: int = summary.statistics.message_start_time
        self.counts: dict[str, int] = {}
        """Messages of each stream."""
        for channel in summary.channels.values():
            count = summary.statistics.channel_message_counts.get(channel.id, 0)
            self.counts[channel.topic] = self.counts.get(channel.topic, 0) + count
        self._metadata = {entry.name: entry.metadata for entry in self.reader.iter_metadata()}
        self._attachments = {entry.name: entry.data for entry in self.reader.iter_attachments()}

    def messages(self, streams: tuple[str, ...]) -> Iterator[tuple[str, str, int, bytes]]:
        """Stream, origin, time in ns and payload of each message of `streams`, in order of time."""
        for _, channel, message in self.reader.iter_messages(topics=streams):
            yield channel.topic, channel.metadata.get(ORIGIN, ""), message.log_time, message.data

    def configuration(self, origin: str) -> dict[str, Any]:
        """The configuration that a recording was made with; raises ValueError when it is not there or no TOML."""
        name = _named(origin, "session")
        text = self._metadata.get(name, {}).get("configuration")
        if text is None:
            raise ValueError(f"{self.path}: its metadata {name} has no configuration")
        try:
            return tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise ValueError(f"{self.path}: its configuration is not TOML: {error}") from None

    def table(self, origin: str, name: str, kind: type[Table]) -> Table:
        """A calibrated table that was in use; raises ValueError when it is not attached or cannot be used."""
        content = self._attachments.get(_named(origin, f"{name}.json"))
        if content is None:
            raise ValueError(f"{self.path}: the table {name}.json is not attached: recorded by an older version")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{name}.json"
            path.write_bytes(content)
            table = kind.load(path)
        if self._metadata.get(_named(origin, "session"), {}).get(name) != table.content_hash:
            raise ValueError(f"{self.path}: the attached {name}.json is not the table that its metadata names")
        return table


def _named(origin: str, name: str) -> str:
    return f"{origin}/{name}" if origin else name
