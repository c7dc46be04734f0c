"""Exports a recording in one of the formats of FORMATS."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from importlib import import_module
from pathlib import Path

from teletaction.export.named_recording import NamedRecording

Write = Callable[[NamedRecording, Path], dict[str, int]]


@dataclass(frozen=True, slots=True)
class Format:
    """A format: its content for the help, the function that writes it, and the extra that it needs."""

    content: str
    module: str
    function: str
    extra: str = ""

    def load(self) -> Write:
        """Import the function that writes this format.

        Raises:
            ValueError: a package is missing; the message names the extra to install.
        """
        try:
            write: Write = getattr(import_module(f"teletaction.export.{self.module}"), self.function)
        except ModuleNotFoundError as error:
            raise ValueError(f"needs {error.name}: pip install 'teletaction[{self.extra}]'") from None
        return write


FORMATS = {
    "csv": Format("one CSV file a stream", "csv_tables", "write_csv"),
    "parquet": Format("one Parquet file a stream, with types and units", "parquet_tables", "write_parquet", "parquet"),
    "foxglove": Format("session.mcap with JSON messages", "foxglove", "write_foxglove"),
    "fhir": Format("findings as FHIR R4, findings.fhir.json", "fhir", "write_fhir"),
    "rerun": Format("session.rrd with every number as a curve", "rerun_file", "write_rerun", "rerun"),
}


def export(recording: Path, to: str, out: Path, began: datetime | None = None) -> dict[str, int]:
    """Write a recording into the folder `out`, which is created.

    Args:
        recording: a recording of one site, or a merged `session.mcap`.
        to: a key of FORMATS.
        out: folder for the files; files of the same names are replaced.
        began: wall-clock time of the first message, for a recording without a clock anchor.

    Returns:
        Number of messages or rows of each stream.

    Raises:
        OSError: the recording cannot be read, or a file cannot be written.
        ValueError: the format is unknown or needs a package, the recording is damaged or has no wall-clock time, or
            `out` would replace it.
    """
    if to not in FORMATS:
        raise ValueError(f"no format {to!r}; choose one of {', '.join(FORMATS)}")
    write = FORMATS[to].load()
    with recording.open("rb") as file:
        named = NamedRecording(recording, file, began)
        out.mkdir(parents=True, exist_ok=True)
        if recording.resolve().parent == out.resolve():
            raise ValueError(f"{out}: is the folder of the recording; name another one with --out")
        return write(named, out)
