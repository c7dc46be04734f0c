"""Reads each recorded stream as named fields, and gives its JSON schema."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from msgspec import inspect

from common.fingers import FINGERS
from common.recording.recorded_fields import unpack
from common.recording.recorded_row import Row
from common.wire.messages import (
    OBJECT_UNKNOWN_SD_K,
    Event,
    EventKind,
    ExplorationMode,
    Motion,
    MotionRow,
    ThermalReason,
    ThermalStatus,
    Touch,
    TouchRow,
    columns,
)
from common.wire.touch_summary import TouchSummary
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.examination.journal import SCHEMAS as CONSOLE_STREAMS
from operator_site.console.voice.voice_sound import VoiceSound
from sim_sensors.truth_log import OPERATOR_STREAMS, REMOTE_STREAMS
from teletaction.export.named_fields import (
    Named,
    Naming,
    Schema,
    finite,
    grouped,
    naming_of,
    number_schema,
    object_schema,
    schema_of,
)
from teletaction.recordings.recorded_rows import ROWS, read

_TEXT: Schema = {"type": "string"}


@dataclass(frozen=True, slots=True)
class Topic:
    """A recorded stream: how a payload becomes named fields, and their JSON schema."""

    read: Callable[[bytes], Named]
    """Raises ValueError for a payload that is no message of this stream."""
    schema: Schema


def _name_of(codes: type[EventKind | ExplorationMode | ThermalReason | ThermalStatus]) -> Naming:
    return lambda code: codes(int(code)).name.lower()


_CODES: dict[str, Naming] = {
    "mode": _name_of(ExplorationMode),
    "thermal_status": _name_of(ThermalStatus),
    "thermal_reason": _name_of(ThermalReason),
}
"""Columns of a touch row that hold a code."""
_ROW_CODES: dict[str, Naming] = {
    "finger": lambda finger: FINGERS[finger],
    "kind": _name_of(EventKind),
    "status": _name_of(ThermalStatus),
}
"""Fields of recorded rows that hold a code."""


def _row(kind: type[Row]) -> Topic:
    info = inspect.type_info(kind)
    naming, schema = naming_of(info), schema_of(info)
    codes = {name: code for name, code in _ROW_CODES.items() if name in kind.__struct_fields__}
    schema["properties"].update(dict.fromkeys(codes, _TEXT))

    def read(payload: bytes) -> Named:
        named: Named = naming(kind.unpack(payload))
        return named | {name: code(named[name]) for name, code in codes.items()}

    return Topic(read, schema)


_HEADER: dict[str, Schema] = {
    "session": {"type": "string", "description": "number of the session"},
    "sequence": {"type": "integer"},
    "time_ns": {"type": "integer", "unit": "ns", "description": "source time, monotonic clock of the sender"},
    "state": {"type": "string", "description": "state of the link"},
}


def _header(packet: Motion | Touch) -> Named:
    return {
        "session": str(packet.session),
        "sequence": packet.sequence,
        "time_ns": packet.time_ns,
        "state": packet.state.name.lower(),
    }


def _read_motion(payload: bytes) -> Named:
    motion = Motion.decode(payload)
    rows = [{name: finite(value) for name, value in row._asdict().items()} for row in motion.rows]
    return _header(motion) | dict(zip(FINGERS, rows, strict=True))


def _unknown(row: TouchRow) -> list[str]:
    """Return the columns of a row whose numbers stand for unknown values, as `docs/protocols.md` states."""
    names = []
    if row.stiffness_n_m == 0.0:
        names += ["stiffness_n_m", "stiffness_ln_sd", "damping_n_s_m", "slope_x", "slope_y"]
    if row.conductivity_w_mk == 0.0:
        names += ["conductivity_w_mk", "density_kg_m3", "specific_heat_j_kgk", "effusivity_ln_sd"]
    if row.object_c_sd >= OBJECT_UNKNOWN_SD_K or row.thermal_status == ThermalStatus.NONE:
        names += ["object_c", "object_c_sd"]
    return names


def _read_touch(payload: bytes) -> Named:
    touch = Touch.decode(payload)
    named = _header(touch)
    for finger, row, material, summary in zip(FINGERS, touch.rows, touch.materials, touch.summaries, strict=True):
        numbers = row._asdict()
        named[finger] = numbers | {name: code(numbers[name]) for name, code in _CODES.items()} | {"material": material}
        named[finger] |= dict.fromkeys(_unknown(row))
        candidates = [{"material": name, "probability": share} for name, share in summary.candidates]
        named[finger] |= summary._asdict() | {"candidates": candidates}
    named["events"] = [_event(event) for event in touch.events]
    return named


_event = naming_of(inspect.type_info(Event))


def _packet_schema(row: type[MotionRow | TouchRow], more: Mapping[str, Schema], **parts: Schema) -> Schema:
    numbers = {name: number_schema(name, column.unit, column.meaning) for name, column in columns(row).items()}
    codes = {name: {**_TEXT, "description": numbers[name]["description"]} for name in _CODES if name in numbers}
    return object_schema({**_HEADER, **parts}, numbers | codes | dict(more))


_MOTION = Topic(_read_motion, _packet_schema(MotionRow, {}))
_CANDIDATE: Schema = {"type": "object", "properties": {"material": _TEXT, "probability": {"type": "number"}}}
_SUMMARY = schema_of(inspect.type_info(TouchSummary))["properties"] | {
    "candidates": {"type": "array", "items": _CANDIDATE}
}
_TOUCH = Topic(
    _read_touch,
    _packet_schema(
        TouchRow,
        {"material": _TEXT, **_SUMMARY},
        events={"type": "array", "items": schema_of(inspect.type_info(Event))},
    ),
)


def _truth(stream: str, schema: Mapping[str, Any]) -> Topic:
    """Return the topic of a stream of maps: its fields in the schema, which the recording holds too."""
    fields: Mapping[str, Mapping[str, Any]] = schema["properties"]
    fingers = [name for name, field in fields.items() if field["type"] == "array"]

    def named(payload: bytes) -> Named:
        found = read(stream, payload)
        plain = {name: found[name] for name in fields if name not in fingers}
        codes = {"finger": FINGERS[plain["finger"]]} if "finger" in plain else {}
        return grouped(plain | codes, {name: found[name] for name in fingers})

    typed = {
        name: _TEXT if name == "finger" else number_schema(name) | {"type": field.get("items", field)["type"]}
        for name, field in fields.items()
    }
    return Topic(named, object_schema({n: typed[n] for n in typed if n not in fingers}, {n: typed[n] for n in fingers}))


def _map(payload: bytes) -> Named:
    found = unpack(payload)
    if not isinstance(found, dict):
        raise ValueError("not a map of named fields")
    try:
        json.dumps(found)
    except TypeError as error:
        raise ValueError(f"a field has no text: {error}") from None
    return {str(name): value for name, value in found.items()}


def _note(payload: bytes) -> Named:
    return {"text": str(unpack(payload))}


def _sized(kind: type[Picture] | type[VoiceSound]) -> Callable[[bytes], Named]:
    """Return the function that reads a picture or a sound, with the size of its content in place of it."""

    def read(payload: bytes) -> Named:
        named = kind.of_record(payload).record()
        return named | {"content": len(named["content"])}

    return read


_CAPTURED: dict[str, Schema] = {
    "sequence": {"type": "integer"},
    "captured_s": number_schema("captured_s", meaning="operator site's clock"),
    "uncertainty_s": number_schema("uncertainty_s"),
}
_CAMERA = Topic(
    _sized(Picture),
    object_schema(
        {
            **_CAPTURED,
            "is_key": {"type": "boolean"},
            "width": {"type": "integer", "unit": "pixel"},
            "height": {"type": "integer", "unit": "pixel"},
            "content": {"type": "integer", "unit": "byte", "description": "size of the picture, which is left out"},
        },
        {},
    ),
)


_VOICE = Topic(
    _sized(VoiceSound),
    object_schema(
        {
            "direction": _TEXT,
            **_CAPTURED,
            "content": {"type": "integer", "unit": "byte", "description": "size of the sound, which is left out"},
        },
        {},
    ),
)
_FREE = Topic(_map, {"type": "object"})
TOPICS: dict[str, Topic] = {
    "remote/motion": _MOTION,
    "operator/motion": _MOTION,
    "remote/touch": _TOUCH,
    "operator/touch": _TOUCH,
    "remote/note": Topic(_note, {"type": "object", "properties": {"text": _TEXT}}),
    "operator/figures": _FREE,
    **{stream: _row(kind) for stream, kind in ROWS.items()},
    **{stream: _truth(stream, schema) for stream, schema in (OPERATOR_STREAMS | REMOTE_STREAMS).items()},
    **dict.fromkeys(CONSOLE_STREAMS, _FREE),
    "console/camera": _CAMERA,
    "console/voice": _VOICE,
}
"""All streams that the processes of a session record, by name."""
