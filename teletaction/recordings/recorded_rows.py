"""Decodes the recorded streams that reports use."""

from collections.abc import Mapping
from typing import Any

from common.link.session_state import Happening
from common.recording.recorded_fields import Map, map_of, read_map
from common.recording.recorded_row import FingerNumber, Five, Row, Whole
from common.wire.messages import Touch
from operator_site.recorded_rows import Played, Rendered, Skin
from remote_site.recorded_rows import Gate, SentEvent, Thermal
from sim_sensors.truth_log import OPERATOR_STREAMS, REMOTE_STREAMS

_ROWS: dict[str, type[Row]] = {
    "operator/rendered": Rendered,
    "operator/skin": Skin,
    "operator/played": Played,
    "operator/session": Happening,
    "remote/session": Happening,
    "remote/gate": Gate,
    "remote/event": SentEvent,
    "remote/thermal": Thermal,
}
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
STREAMS = (*_ROWS, *_MAPS, "remote/touch")
"""Names of all streams that `read` decodes."""


def read(stream: str, payload: bytes) -> Any:
    """Decode a message of one of STREAMS: a touch packet, a row or a map.

    Raises:
        ValueError: the payload is no message of this stream.
    """
    if stream == "remote/touch":
        return Touch.decode(payload)
    if stream in _MAPS:
        return read_map(payload, _MAPS[stream])
    return _ROWS[stream].unpack(payload)
