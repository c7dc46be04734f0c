"""Decodes the recorded streams of rows and maps."""

from collections.abc import Mapping
from typing import Any

from common.link.session_state import Happening
from common.recording.recorded_fields import Map, map_of, read_map
from common.recording.recorded_row import FingerNumber, Five, Row, Whole
from common.tenderness.patient_row import Patient
from common.wire.messages import Touch
from operator_site.coupling.coupling import Coupling
from operator_site.recorded_rows import Clock, Played, Rendered, RenderingInput, Skin
from remote_site.devices.sensor_frame import SensorFrame
from remote_site.recorded_rows import Gate, SentEvent, Thermal
from sim_sensors.truth_log import OPERATOR_STREAMS, REMOTE_STREAMS

ROWS: dict[str, type[Row]] = {
    "remote/session": Happening,
    "remote/sensed": SensorFrame,
    "remote/gate": Gate,
    "remote/event": SentEvent,
    "remote/patient": Patient,
    "remote/thermal": Thermal,
    "operator/session": Happening,
    "operator/coupling": Coupling,
    "operator/input": RenderingInput,
    "operator/rendered": Rendered,
    "operator/skin": Skin,
    "operator/played": Played,
    "operator/clock": Clock,
}
"""Type of the rows of each stream of rows."""
_UNUSED = frozenset(("remote/sensed", "remote/patient", "operator/coupling", "operator/input", "operator/clock"))
"""Streams of rows that a report's series do not have."""
_TYPES: dict[str, Any] = {"number": float, "integer": Whole, "string": str}
_FIVES: dict[str, Any] = {"number": Five[float], "integer": Five[Whole]}


def _type(name: str, schema: Mapping[str, Any]) -> Any:
    """Return the type of a field from its name and its JSON schema in the truth log."""
    if name == "finger":
        return FingerNumber
    return _FIVES[schema["items"]["type"]] if schema["type"] == "array" else _TYPES[schema["type"]]


_MAPS: dict[str, Map] = {
    stream: map_of(**{name: _type(name, field) for name, field in schema["properties"].items()})  # type: ignore[attr-defined]
    for stream, schema in (OPERATOR_STREAMS | REMOTE_STREAMS).items()
}
STREAMS = (*(stream for stream in ROWS if stream not in _UNUSED), *_MAPS, "remote/touch")
"""Names of the streams that reports use."""


def read(stream: str, payload: bytes) -> Any:
    """Decode a message: a touch packet, a row or a map.

    Raises:
        ValueError: the payload is no message of this stream.
    """
    if stream == "remote/touch":
        return Touch.decode(payload)
    if stream in _MAPS:
        return read_map(payload, _MAPS[stream])
    return ROWS[stream].unpack(payload)
