"""The fields of the recorded streams that reports are made of, and how each is read."""

from collections.abc import Mapping
from typing import Any

from common.messages import Touch
from common.recorded_fields import Fits, finger, five, flag, maybe, number, read_map, read_row, real, text, whole
from sim_sensors.truth_log import OPERATOR_STREAMS, REMOTE_STREAMS

RENDERED: dict[str, Fits] = {
    "engaged": flag,
    "age_s": maybe(number),
    "force_n": five(number),
    "motor_rpm": five(number),
    "plate_set_c": five(number),
    "peltier": five(number),
    "limits": five(whole),
    "fault": maybe(text),
    "x_m": real,
    "y_m": real,
    "z_m": five(real),
    "plate_c": five(real),
    "sequence": maybe(whole),
    "written_s": number,
}
_SESSION: dict[str, Fits] = {"what": text, "session": whole, "text": text}
_ROWS: dict[str, dict[str, Fits]] = {
    "operator/rendered": RENDERED,
    "operator/skin": {"felt_c": five(number), "surface_c": five(number), "flux_w_m2": five(number)},
    "operator/played": {"ident": whole, "kind": whole, "finger": finger},
    "operator/session": _SESSION,
    "remote/session": _SESSION,
    "remote/gate": {
        "x_m": real,
        "y_m": real,
        "z_m": five(real),
        "heater": five(number),
        "limits": five(whole),
        "fault": maybe(text),
    },
    "remote/event": {
        "ident": whole,
        "kind": whole,
        "finger": finger,
        "time_ns": whole,
        "value": number,
        "name": text,
    },
    "remote/thermal": {
        "finger": finger,
        "status": whole,
        "best": maybe(text),
        "probability": maybe(real),
        "object_c": maybe(real),
        "object_c_sd": maybe(real),
        "rate_per_s": maybe(real),
        "exponential_object_c": maybe(real),
        "exponential_material": maybe(text),
        "reason": maybe(text),
        "roughness_v": maybe(real),
        "stiffness_n_m": maybe(real),
    },
}
_KINDS: dict[str, Fits] = {"number": real, "integer": whole, "string": text}


def _fits(schema: Mapping[str, Any]) -> Fits:
    """What a field of the truth's JSON schema allows."""
    return five(_KINDS[schema["items"]["type"]]) if schema["type"] == "array" else _KINDS[schema["type"]]


_MAPS: dict[str, dict[str, Fits]] = {
    stream: {name: _fits(field) for name, field in schema["properties"].items()}  # type: ignore[attr-defined]
    for stream, schema in (OPERATOR_STREAMS | REMOTE_STREAMS).items()
}
STREAMS = (*_ROWS, *_MAPS, "remote/touch")


def read(stream: str, payload: bytes) -> Any:
    """A message of one of STREAMS: a touch packet, a list of fields in order, or a map.

    Raises:
        ValueError: it is something else.
    """
    if stream == "remote/touch":
        return Touch.decode(payload)
    if stream in _MAPS:
        return read_map(payload, _MAPS[stream])
    return read_row(payload, _ROWS[stream])
