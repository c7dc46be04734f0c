"""Each recorded stream has a topic whose schema names exactly the fields of its messages."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgpack
import pytest

from common.fingers import FINGERS
from common.wire.messages import NO_TOUCH, OBJECT_UNKNOWN_SD_K, ThermalStatus, Touch, TouchRow, columns, pack_rows
from common.wire.packets import LinkState
from operator_site import site_recording as operator_recording
from operator_site.console.examination.journal import SCHEMAS as CONSOLE
from remote_site import site_recording as remote_recording
from sim_sensors.truth_log import OPERATOR_STREAMS, REMOTE_STREAMS
from teletaction.export.named_fields import unit_of
from teletaction.export.topics import TOPICS
from teletaction.recordings.recorded_session import RecordedSession
from tests.places import GOLDEN


def messages(path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    with path.open("rb") as file:
        recorded = RecordedSession(path, file)
        for topic, _, _, payload in recorded.messages(tuple(recorded.counts)):
            yield topic, TOPICS[topic].read(payload)


def test_no_recorded_stream_is_without_a_topic() -> None:
    remote = remote_recording.SCHEMAS | remote_recording.PATIENT_SCHEMAS
    recorded = [remote, operator_recording.SCHEMAS, CONSOLE, OPERATOR_STREAMS, REMOTE_STREAMS]
    assert {stream for schemas in recorded for stream in schemas} == set(TOPICS)


def misfits(fields: Any, schema: Mapping[str, Any], where: str) -> Iterator[str]:
    """Places at which named fields do not have the form that their schema states."""
    match schema["type"]:
        case "object":
            properties = schema.get("properties")
            if fields is None or properties is None:
                return
            if set(fields) != set(properties):
                yield f"{where}: {sorted(set(fields) ^ set(properties))}"
            for name in properties.keys() & fields.keys():
                yield from misfits(fields[name], properties[name], f"{where}.{name}")
        case "array":
            for value in fields or ():
                yield from misfits(value, schema["items"], where)
        case "number":
            if not (fields is None or (isinstance(fields, int | float) and math.isfinite(fields))):
                yield f"{where}: {fields!r} is no finite number"
        case kind:
            if not (fields is None or isinstance(fields, {"integer": int, "string": str, "boolean": bool}[kind])):
                yield f"{where}: {fields!r} is no {kind}"


@pytest.mark.long
@pytest.mark.parametrize("source", ["golden", "session"])
def test_messages_have_the_form_of_their_schema(source: str, session: Path) -> None:
    seen = set()
    wrong: set[str] = set()
    for topic, fields in messages(GOLDEN if source == "golden" else session):
        seen.add(topic)
        wrong |= {*misfits(fields, TOPICS[topic].schema, topic)}
    assert wrong == set()
    assert len(seen) >= (5 if source == "golden" else 15)


def test_a_touch_has_the_units_of_the_packet() -> None:
    index = TOPICS["remote/touch"].schema["properties"]["index"]["properties"]
    stated = {name: index[name].get("unit", "") for name in columns(TouchRow) if index[name]["type"] == "number"}
    assert stated == {name: column.unit for name, column in columns(TouchRow).items() if name in stated}


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("object_c", "C"),
        ("object_c_sd", "C"),
        ("roughness_sd_v", "V"),
        ("stiffness_n_m", "N/m"),
        ("stiffness_ln_sd", "1"),
        ("rate_per_s", "1/s"),
        ("flux_w_m2", "W/m2"),
        ("approach_m_s", "m/s"),
        ("probability", ""),
        ("what", ""),
    ],
)
def test_the_unit_of_a_field_follows_from_its_name(name: str, unit: str) -> None:
    assert unit_of(name) == unit


def test_an_unknown_number_is_none_and_a_finger_has_its_name() -> None:
    _, rendered = next(each for each in messages(GOLDEN) if each[0] == "operator/rendered")
    assert rendered["thumb"]["plate_c"] is None
    assert set(FINGERS) < set(rendered)
    assert isinstance(rendered["index"]["plate_c"], float)


def exported(row: TouchRow) -> dict[str, Any]:
    touch = Touch(1, 1, 1, LinkState.ENGAGED, pack_rows([row, *[NO_TOUCH] * 4]), ("",) * 5, ())
    named: dict[str, Any] = TOPICS["remote/touch"].read(touch.encode())["thumb"]
    return named


def test_a_number_that_stands_for_an_unknown_value_is_none() -> None:
    row = NO_TOUCH._replace(
        stiffness_n_m=850.0,
        conductivity_w_mk=0.2,
        object_c=23.5,
        object_c_sd=0.25,
        thermal_status=ThermalStatus.DECIDING,
    )
    known = exported(row)
    assert (known["stiffness_n_m"], known["object_c"], known["object_c_sd"]) == (850.0, 23.5, 0.25)
    assert known["conductivity_w_mk"] == pytest.approx(0.2)
    nothing = exported(
        row._replace(stiffness_n_m=0.0, conductivity_w_mk=0.0, object_c=0.0, object_c_sd=OBJECT_UNKNOWN_SD_K)
    )
    unused = exported(NO_TOUCH)
    for unknown in (nothing, unused):
        for name in (
            "stiffness_n_m",
            "stiffness_ln_sd",
            "conductivity_w_mk",
            "effusivity_ln_sd",
            "object_c",
            "object_c_sd",
        ):
            assert unknown[name] is None, name
        assert unknown["contact_force_n"] == 0.0


@pytest.mark.parametrize("topic", sorted(TOPICS))
@pytest.mark.parametrize("payload", [b"", b"\xc1", b"\x93\xa1x\x02\x03", b"\xc0"])
def test_a_damaged_payload_is_a_value_error(topic: str, payload: bytes) -> None:
    if topic == "remote/note" and payload not in (b"", b"\xc1"):
        return  # A note is any text.
    with pytest.raises(ValueError):  # noqa: PT011 - each kind of row has its own message
        TOPICS[topic].read(payload)


@pytest.mark.parametrize("topic", ["operator/figures", *CONSOLE])
@pytest.mark.parametrize("value", [b"bytes", [b"bytes"], {b"bytes": 1}, msgpack.Timestamp(1)])
def test_a_map_with_a_value_that_no_text_shows_is_a_value_error(topic: str, value: object) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - each kind of value has its own message
        TOPICS[topic].read(msgpack.packb({"at_s": 1.0, "details": value}))


@pytest.mark.parametrize("finger", [-1, len(FINGERS)])
def test_a_finger_that_no_hand_has_is_a_value_error(finger: int) -> None:
    switched = {"finger": finger, "motor_mv": 500}
    assert set(OPERATOR_STREAMS["truth_motor"]["properties"]) == set(switched)
    with pytest.raises(ValueError, match="finger"):
        TOPICS["truth_motor"].read(msgpack.packb(switched))
