"""Rows of recordings: unchanged bytes, and a refusal of all others."""

import math
from typing import Any

import msgpack
import pytest

from common.link.session_state import Happening
from common.recording.recorded_row import Row
from operator_site.coupling.coupling import Coupling
from operator_site.recorded_rows import Clock, Played, Rendered, RenderingInput, Skin
from remote_site.devices.sensor_frame import SensorFrame
from remote_site.recorded_rows import Gate, SentEvent, Thermal
from tests.places import GOLDEN
from tests.unit.teletaction.held_recordings import held

ONES, LIMITS = [1.0] * 5, [1] * 5
FAULT = ["force-swings", "index", "", 1.5, None, 12.0, "", False]
HAND = [10**15, 0.1, -0.2]
PLATES = [[33.0, 23.0, "", 2**32 - 1, -250], None, None, None, None]
ROWS: list[tuple[type[Row], list[Any]]] = [
    (Happening, ["fault", 7, "", FAULT]),
    (Rendered, [True, None, ONES, ONES, ONES, ONES, LIMITS, FAULT, 0.0, 0.5, ONES, [math.inf] * 5, None, 1.5]),
    (Skin, [ONES, ONES, ONES]),
    (Played, [2**62, 1, 4]),
    (Clock, [-5_000_000, None, 46_000_000]),
    (Gate, [0.0, -0.5, ONES, ONES, LIMITS, None]),
    (SentEvent, [1, 0, 1, 2 * 10**15, 0.5, "pvc"]),
    (Thermal, [1, 3, "pvc", 0.9, 22.0, 0.3, None, None, None, None, 0.1, None]),
    (SensorFrame, [1.0, 0.0, 0.1, ONES, ONES, [b"\0\1", None, None, None, b""], PLATES, HAND]),
    (Coupling, [True, 5, 0.1, 0.2, ONES, 0.1, 0.2, ONES]),
    (RenderingInput, [1.0, 7, False, True, 0, 5, 0.1, 0.2, ONES, -math.inf, 1.0, ONES, ONES, [FAULT]]),
]
GOLDEN_ROWS: dict[str, type[Row]] = {
    "remote/sensed": SensorFrame,
    "operator/input": RenderingInput,
    "operator/rendered": Rendered,
}
each = pytest.mark.parametrize(("kind", "fields"), ROWS, ids=lambda value: getattr(value, "__name__", ""))


@each
def test_a_row_is_its_fields_in_order(kind: type[Row], fields: list[Any]) -> None:
    packed = msgpack.packb(fields)
    assert kind.unpack(packed).pack() == packed


def test_each_row_of_the_golden_recording_comes_back_to_the_last_bit() -> None:
    found = [(GOLDEN_ROWS[topic], payload) for topic, _, payload in held(GOLDEN) if topic in GOLDEN_ROWS]
    assert {kind for kind, _ in found} == set(GOLDEN_ROWS.values())
    assert all(kind.unpack(payload).pack() == payload for kind, payload in found)


@each
def test_a_row_with_one_field_more_or_less_is_refused(kind: type[Row], fields: list[Any]) -> None:
    others: tuple[object, ...] = (fields[:-1], [*fields, None], [], {}, 7)
    for wrong in others:
        with pytest.raises(ValueError, match=f"not a list of {len(fields)} fields"):
            kind.unpack(msgpack.packb(wrong))
    for damaged in (b"", msgpack.packb(fields)[:-1], msgpack.packb(fields) + b"\0", b"\x91" * 3000):
        with pytest.raises(ValueError, match="fields"):
            kind.unpack(damaged)


@each
def test_a_field_of_another_type_is_refused_by_name(kind: type[Row], fields: list[Any]) -> None:
    for number, name in enumerate(kind.__struct_fields__):
        wrong = [*fields[:number], {"a": 1}, *fields[number + 1 :]]
        with pytest.raises(ValueError, match=f"field {name}: "):
            kind.unpack(msgpack.packb(wrong))


@pytest.mark.parametrize(
    ("kind", "number", "wrong"),
    [
        (Rendered, 2, [math.nan] * 5),
        (Rendered, 2, [1.0] * 4),
        (Rendered, 7, ["no-such-code", *FAULT[1:]]),
        (Rendered, 13, math.inf),
        (Rendered, 12, 2**63),
        (Played, 2, 5),
        (SentEvent, 4, math.nan),
        (SensorFrame, 6, [[33.0, 23.0, "", 0]] * 5),
        (SensorFrame, 7, [1, 0.0]),
    ],
)
def test_an_impossible_value_is_refused(kind: type[Row], number: int, wrong: object) -> None:
    fields = list(dict(ROWS)[kind])
    fields[number] = wrong
    with pytest.raises(ValueError, match=f"field {kind.__struct_fields__[number]}"):
        kind.unpack(msgpack.packb(fields))


def test_an_odd_number_of_texture_bytes_is_refused() -> None:
    fields = list(dict(ROWS)[SensorFrame])
    fields[5] = [b"\0\1\2", None, None, None, None]
    with pytest.raises(ValueError, match="16-bit"):
        SensorFrame.unpack(msgpack.packb(fields))


def test_a_schema_names_the_fields() -> None:
    assert Clock.schema() == {
        "type": "array",
        "description": f"[offset_ns, uncertainty_ns or null, round_trip_ns]: {Clock.__doc__}",
    }
    assert "plates x 5 ([sensor_c, ambient_c, fault, device_us, heater_permille]) or null" in str(SensorFrame.schema())
