"""Opens a whole recording for replay: messages, configurations and calibrated tables of each site."""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, TypeVar

from common.files.read_files import NotToml, parse_toml
from common.recording.reader import RecordingReader
from remote_site.tables.table_file import TableFile
from teletaction.recordings.merge import ORIGIN

Table = TypeVar("Table", bound=TableFile)


class RecordedSession:
    """One site's recording, or several merged; in a merged file, each has its own configuration and tables.

    The origin identifies a recording: its name before merging, empty in a file that was not merged.
    """

    def __init__(self, path: Path, file: IO[bytes]):
        """Open `file`, found at `path`; raises ValueError where it is no MCAP file, truncated or damaged."""
        self.path = path
        self.reader = RecordingReader(path, file)
        self.start_ns = self.reader.start_ns
        self.counts = self.reader.counts

    def messages(self, streams: tuple[str, ...]) -> Iterator[tuple[str, str, int, bytes]]:
        """Yield stream, origin, time and payload of each message of `streams`, in order of time.

        The time, ns, is of the operator host's clock in a merged file, else of the recording host's.
        """
        for _, channel, message in self.reader.messages(streams):
            yield channel.topic, channel.metadata.get(ORIGIN, ""), message.log_time, message.data

    def configuration(self, origin: str) -> dict[str, Any]:
        """Return the configuration that a recording was made with.

        Raises:
            ValueError: the configuration is missing or no TOML.
        """
        name = _named(origin, "session")
        text = self.reader.metadata.get(name, {}).get("configuration")
        if text is None:
            raise ValueError(f"{self.path}: its metadata {name} has no configuration")
        try:
            return parse_toml(text)
        except NotToml as error:
            raise ValueError(f"{self.path}: its configuration is {error}") from None

    def table(self, origin: str, name: str, kind: type[Table]) -> Table:
        """Return a calibrated table that the site used.

        Raises:
            ValueError: the table is not attached, cannot be read, or is not the one that the metadata names.
        """
        attached = self.reader.attachments.get(_named(origin, f"{name}.json"))
        if attached is None:
            raise ValueError(f"{self.path}: the table {name}.json is not attached: recorded by an older version")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{name}.json"
            path.write_bytes(attached.data)
            try:
                table = kind.load(path)
            except ValueError as error:
                why = str(error).removeprefix(f"{folder}/")
                raise ValueError(f"{self.path}: the attached {why}") from None
        if self.reader.metadata.get(_named(origin, "session"), {}).get(name) != table.content_hash:
            raise ValueError(f"{self.path}: the attached {name}.json is not the table that its metadata names")
        return table


def _named(origin: str, name: str) -> str:
    return f"{origin}/{name}" if origin else name
