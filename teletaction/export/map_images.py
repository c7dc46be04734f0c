"""Draws the tactile map at the end of a recording, as images that Foxglove shows."""

import base64
from collections.abc import Iterator

from operator_site.console.map.tactile_map import QUANTITIES
from teletaction.export.log_entries import TIMESTAMP_SCHEMA, timestamp
from teletaction.export.named_fields import Named, Schema
from teletaction.export.named_recording import NamedRecording
from teletaction.report.examination import Examination
from teletaction.report.map_figure import map_figure
from teletaction.report.report_parts import png

DPI = 100
IMAGE_SCHEMA: Schema = {
    "type": "object",
    "properties": {
        "timestamp": TIMESTAMP_SCHEMA,
        "frame_id": {"type": "string"},
        "data": {"type": "string", "contentEncoding": "base64"},
        "format": {"type": "string"},
    },
}
"""Schema of `foxglove.CompressedImage`."""


def map_images(recording: NamedRecording) -> Iterator[tuple[str, Named]]:
    """Yield each explored quantity with the image of its map, as `foxglove.CompressedImage` has it."""
    examination = Examination.read(recording.path)
    findings = examination.valid_findings()
    for quantity in QUANTITIES:
        drawn = map_figure(examination.felt, quantity, findings)
        if drawn is not None:
            data = base64.b64encode(png(drawn, DPI)).decode("ascii")
            stamp = timestamp(recording.end_ns)
            yield quantity, {"timestamp": stamp, "frame_id": quantity, "data": data, "format": "png"}
