"""Exports a recording in one of the formats of FORMATS."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from common.privacy.recording_file import open_recording
from teletaction.export.body_site import BodySite
from teletaction.export.named_recording import NamedRecording
from teletaction.export.optional_package import load_optional


@dataclass(frozen=True, slots=True)
class Format:
    """A format: its content for the help, the function that writes it, the extra that it needs.

    The function writes a NamedRecording into a folder, and returns the number of messages or rows of each part. It
    raises OSError for a file that cannot be written, and ValueError for a damaged recording. A clinical format has the
    findings of an examination; its function also takes the BodySite or None.
    """

    content: str
    module: str
    function: str
    extra: str = ""
    clinical: bool = False


FORMATS = {
    "csv": Format("one CSV file a stream", "csv_tables", "write_csv"),
    "parquet": Format("one Parquet file a stream, with types and units", "parquet_tables", "write_parquet", "parquet"),
    "foxglove": Format("session.mcap with JSON messages", "foxglove", "write_foxglove"),
    "fhir": Format("findings as FHIR R4, findings.fhir.json", "fhir", "write_fhir", clinical=True),
    "dicom-sr": Format("findings as DICOM SR, findings.dcm", "dicom_sr", "write_dicom_sr", "dicom", clinical=True),
    "rerun": Format("session.rrd with every number as a curve", "rerun_file", "write_rerun", "rerun"),
}


def export(
    recording: Path, to: str, out: Path, began: datetime | None = None, body_site: str | None = None
) -> dict[str, int]:
    """Write a recording into the folder `out`, which is created.

    Args:
        recording: a recording of one site, or a merged `session.mcap`.
        to: a key of FORMATS.
        out: folder for the files; files of the same names are replaced.
        began: wall-clock time of the first message, for a recording without a clock anchor.
        body_site: examined part of the body, `left breast` or `SCT:80248007:left breast`, for a clinical format.

    Returns:
        Number of messages or rows of each stream.

    Raises:
        OSError: the recording cannot be read, or a file cannot be written.
        ValueError: the format is unknown, needs a package or takes no body site, the body site is written otherwise,
            the recording is damaged or has no wall-clock time, or `out` would replace it.
    """
    if to not in FORMATS:
        raise ValueError(f"no format {to!r}; choose one of {', '.join(FORMATS)}")
    chosen = FORMATS[to]
    if body_site is not None and not chosen.clinical:
        clinical = " or ".join(name for name, known in FORMATS.items() if known.clinical)
        raise ValueError(f"{to} takes no body site; export to {clinical}")
    clinical_options = (None if body_site is None else BodySite.parse(body_site),) if chosen.clinical else ()
    write: Callable[..., dict[str, int]] = load_optional(
        f"teletaction.export.{chosen.module}", chosen.function, chosen.extra
    )
    with open_recording(recording) as file:
        named = NamedRecording(recording, file, began)
        out.mkdir(parents=True, exist_ok=True)
        if recording.resolve().parent == out.resolve():
            raise ValueError(f"{out}: is the folder of the recording; name another one with --out")
        return write(named, out, *clinical_options)
