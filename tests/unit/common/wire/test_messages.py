import contextlib
import math
import struct
from collections.abc import Callable
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.messages import (
    MAX_EVENTS,
    TOUCH_BLOCK,
    TOUCH_FIELDS,
    TOUCH_RANGES,
    Event,
    EventKind,
    Motion,
    ThermalReason,
    ThermalStatus,
    Touch,
    explains,
    motion_packet,
)
from common.wire.packets import MAX_PACKET, SCHEMA_VERSION, BadPacket, LinkState, WrongVersion
from common.wire.session_messages import REQUESTS, Answer, Heartbeat, Request
from common.wire.touch_summary import MAX_CANDIDATES, NOTHING, TouchSummary

KINDS: dict[str, Any] = {
    "motion": Motion,
    "touch": Touch,
    "heartbeat": Heartbeat,
    "heartbeat_answer": Heartbeat,
    "hello": Request,
    "hello_answer": Answer,
    "engage": Request,
    "status_answer": Answer,
    "refusal": Answer,
}
names = st.sampled_from(sorted(KINDS))
rubbish = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats()
    | st.text(max_size=50)
    | st.binary(max_size=400),
    lambda inner: (
        st.lists(inner, max_size=8) | st.dictionaries(st.text(max_size=5) | st.integers(0, 9), inner, max_size=4)
    ),
    max_leaves=12,
)


def only_bad_packet(decode: Callable[[bytes], object], packet: bytes) -> None:
    with contextlib.suppress(BadPacket):
        decode(packet)


@given(names, st.binary(max_size=300))
def test_random_bytes_raise_only_bad_packet(name: str, packet: bytes) -> None:
    only_bad_packet(KINDS[name].decode, packet)


@given(names, st.data())
def test_mutated_packets_raise_only_bad_packet(golden: dict[str, bytes], name: str, data: st.DataObject) -> None:
    packet = bytearray(golden[name])
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(packet) - 1))
        match data.draw(st.sampled_from(("change", "cut", "insert"))):
            case "change":
                packet[at] = data.draw(st.integers(0, 255))
            case "cut":
                del packet[max(1, at) :]
            case "insert":
                packet[at:at] = data.draw(st.binary(max_size=5))
    only_bad_packet(KINDS[name].decode, bytes(packet))


@given(names, st.data())
def test_any_value_in_any_field_raises_only_bad_packet(
    golden: dict[str, bytes], name: str, data: st.DataObject
) -> None:
    fields = msgpack.unpackb(golden[name])
    fields[data.draw(st.integers(0, len(fields) - 1))] = data.draw(rubbish)
    only_bad_packet(KINDS[name].decode, msgpack.packb(fields))


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("nest", [b"\x91", b"\x81\xa1a"])
def test_deep_nesting_in_any_field_raises_only_bad_packet(golden: dict[str, bytes], name: str, nest: bytes) -> None:
    fields = msgpack.unpackb(golden[name])
    for depth in (50, 900, 1020):
        for at in range(len(fields)):
            packed = [msgpack.packb(field) for field in fields]
            packed[at] = nest * depth + b"\xc0"
            packet = bytes((0x90 + len(fields),)) + b"".join(packed)
            with pytest.raises(BadPacket):
                KINDS[name].decode(packet)


@pytest.mark.parametrize("name", KINDS)
def test_each_headers_field_is_checked(golden: dict[str, bytes], name: str) -> None:
    fields = msgpack.unpackb(golden[name])
    for at in range(1, 4):
        for bad in (-1, 2**63, 1.0, True, None, "1", [1]):
            with pytest.raises(BadPacket):
                KINDS[name].decode(msgpack.packb([*fields[:at], bad, *fields[at + 1 :]]))
    for wrong in (fields[:-1], [*fields, 0], [], {}, 7):
        with pytest.raises(BadPacket):
            KINDS[name].decode(msgpack.packb(wrong))
    with pytest.raises(BadPacket):
        KINDS[name].decode(golden[name] + b"\0")
    for version in (0, SCHEMA_VERSION + 1, True, float(SCHEMA_VERSION), None, str(SCHEMA_VERSION)):
        with pytest.raises(WrongVersion, match=f"speaks {SCHEMA_VERSION}"):
            KINDS[name].decode(msgpack.packb([version, *fields[1:]]))


@pytest.mark.parametrize("name", ["motion", "touch", "heartbeat"])
def test_an_unknown_state_is_refused(golden: dict[str, bytes], name: str) -> None:
    fields = msgpack.unpackb(golden[name])
    for bad in (4, -1, 1.0, "engaged", None, True):
        with pytest.raises(BadPacket, match="field state"):
            KINDS[name].decode(msgpack.packb([*fields[:4], bad, *fields[5:]]))


def touch_with(golden: dict[str, bytes], position: int, value: object) -> bytes:
    """The touch of the document with another value in one of its fields."""
    fields = msgpack.unpackb(golden["touch"])
    fields[position] = value
    return bytes(msgpack.packb(fields))


def beyond(low: float, high: float) -> list[float]:
    span = (high - low) * 1e-3
    return [low - span, high + span, math.nan, math.inf, -math.inf]


@pytest.mark.parametrize("column", range(len(TOUCH_FIELDS)), ids=TOUCH_FIELDS)
def test_each_touch_column_out_of_range_is_neither_taken_nor_sent(golden: dict[str, bytes], column: int) -> None:
    name = TOUCH_FIELDS[column]
    low, high = TOUCH_RANGES[name]
    fields = msgpack.unpackb(golden["touch"])
    for finger in (0, 4):
        _put(fields, len(TOUCH_FIELDS) * finger + TOUCH_FIELDS.index("thermal_status"), ThermalStatus.UNIDENTIFIABLE)
        for value in (low, high):
            _put(fields, len(TOUCH_FIELDS) * finger + column, value)
            Touch.decode(msgpack.packb(fields))
        for value in beyond(low, high):
            _put(fields, len(TOUCH_FIELDS) * finger + column, value)
            with pytest.raises(BadPacket, match=name):
                Touch.decode(msgpack.packb(fields))
            with pytest.raises(BadPacket, match=name):
                Touch(1, 1, 1, LinkState.ENGAGED, fields[5], ("",) * 5, ()).encode()
        _put(fields, len(TOUCH_FIELDS) * finger + column, low)


@pytest.mark.parametrize("status", ThermalStatus)
@pytest.mark.parametrize("reason", ThermalReason)
def test_a_reason_that_does_not_explain_its_status_is_neither_taken_nor_sent(
    golden: dict[str, bytes], status: ThermalStatus, reason: ThermalReason
) -> None:
    fields = msgpack.unpackb(golden["touch"])
    for name, value in (("thermal_status", status), ("thermal_reason", reason)):
        _put(fields, len(TOUCH_FIELDS) * 3 + TOUCH_FIELDS.index(name), value)
    packet, sent = msgpack.packb(fields), Touch(1, 1, 1, LinkState.ENGAGED, fields[5], ("",) * 5, ())
    if explains(reason, status):
        assert Touch.decode(packet).floats == fields[5]
        sent.encode()
        return
    with pytest.raises(BadPacket, match=r"ring: codes .* do not agree"):
        Touch.decode(packet)
    with pytest.raises(BadPacket, match=r"ring: codes .* do not agree"):
        sent.encode()


@pytest.mark.parametrize(("column", "limit"), [(0, 0.66), (1, 0.66), (2, 0.0103)])
def test_each_motion_column_out_of_range_is_neither_taken_nor_sent(
    golden: dict[str, bytes], column: int, limit: float
) -> None:
    fields = msgpack.unpackb(golden["motion"])
    for value in beyond(-limit, limit):
        _put(fields, 6 + column, value)
        with pytest.raises(BadPacket, match="middle"):
            Motion.decode(msgpack.packb(fields))
        with pytest.raises(BadPacket, match="middle"):
            motion_packet(1, 1, 1, LinkState.ENGAGED, fields[5])


def _put(fields: list[Any], index: int, value: float) -> None:
    fields[5] = fields[5][: 4 * index] + struct.pack("<f", value) + fields[5][4 * index + 4 :]


@pytest.mark.parametrize("block", [b"", bytes(499), bytes(501), "text", None, [0.0] * 125])
def test_a_block_of_another_size_is_refused(golden: dict[str, bytes], block: object) -> None:
    with pytest.raises(BadPacket, match=r"expected 520 bytes|field floats"):
        Touch.decode(touch_with(golden, 5, block))


BAD_IN_EVENT: dict[str, tuple[object, ...]] = {
    "ident": (-1, 1.0),
    "kind": (3,),
    "finger": (5, -1),
    "time_ns": (-1, None),
    "hand_ns": (-1, 0.0),
    "value": (1, -0.1, 2001.0, math.nan, math.inf),
    "name": ("x" * 41, b"pvc", None),
}


@pytest.mark.parametrize(("name", "bad"), [(name, bad) for name, found in BAD_IN_EVENT.items() for bad in found])
def test_each_field_of_an_event_is_checked(golden: dict[str, bytes], name: str, bad: object) -> None:
    news = msgpack.unpackb(msgpack.unpackb(golden["touch"])[6])
    news[1][1][Event._fields.index(name)] = bad
    with pytest.raises(BadPacket):
        Touch.decode(touch_with(golden, 6, msgpack.packb(news)))


def test_lists_of_names_and_events_have_their_lengths(golden: dict[str, bytes]) -> None:
    fields = msgpack.unpackb(golden["touch"])
    names, events = msgpack.unpackb(fields[6])
    for news in (
        [[""] * 4, events],
        [[""] * 6, events],
        ["pvc", events],
        [[1] * 5, events],
        [["x" * 41] + [""] * 4, events],
        [names, [events[0]] * (MAX_EVENTS + 1)],
        [names, [events[0][:5]]],
        [names, {}],
        [names, [1]],
        [names],
        [names, events, 0],
        7,
    ):
        with pytest.raises(BadPacket):
            Touch.decode(touch_with(golden, 6, msgpack.packb(news)))
    for unread in ([names, events], None, "text", b"", fields[6] + b"\0", fields[6][:-1], {}):
        with pytest.raises(BadPacket):
            Touch.decode(touch_with(golden, 6, unread))


@pytest.mark.parametrize(
    "finger",
    [
        [],
        [[], None, None, None],
        [[], None, None, None, None, None],
        [None, None, None, None, None],
        [[["pvc", 0.5]] * (MAX_CANDIDATES + 1), None, None, None, None],
        *([[["pvc", bad]], None, None, None, None] for bad in (1, 1.01, math.nan)),
        *([[bad], None, None, None, None] for bad in (["pvc"], [1, 0.5], ["x" * 41, 0.5])),
        [[], -0.1, None, None, None],
        [[], 1, None, None, None],
        [[], None, math.inf, None, None],
        [[], None, None, 0.11, None],
        [[], None, None, None, "0.1"],
        7,
    ],
)
def test_each_summary_of_a_finger_is_checked(golden: dict[str, bytes], finger: object) -> None:
    summaries = msgpack.unpackb(msgpack.unpackb(golden["touch"])[7])
    with pytest.raises(BadPacket, match="summaries"):
        Touch.decode(touch_with(golden, 7, msgpack.packb([*summaries[:4], finger])))


def test_each_finger_has_a_summary(golden: dict[str, bytes]) -> None:
    fields = msgpack.unpackb(golden["touch"])
    summaries = msgpack.unpackb(fields[7])
    for unread in (summaries, None, "text", b"", fields[7] + b"\0", msgpack.packb(summaries[:4]), msgpack.packb(7)):
        with pytest.raises(BadPacket):
            Touch.decode(touch_with(golden, 7, unread))


def test_every_sent_summary_would_be_accepted() -> None:
    block = TOUCH_BLOCK.to_bytes(np.zeros((5, len(TOUCH_FIELDS)), np.float32))
    for wrong in (TouchSummary((("pvc", 1.5),)), TouchSummary((), math.nan), TouchSummary(groove_m=1.0)):
        with pytest.raises(BadPacket, match="summaries"):
            Touch(1, 1, 1, LinkState.ENGAGED, block, ("",) * 5, (), (wrong, *(NOTHING,) * 4)).encode()


def test_the_fullest_touch_packet_fits() -> None:
    block = np.zeros((5, len(TOUCH_FIELDS)), np.float32)
    events = tuple(Event(2**62 + n, EventKind.MATERIAL, 4, 2**62, 2**62, 0.5, "m" * 40) for n in range(MAX_EVENTS))
    summaries = (TouchSummary((("m" * 40, 0.25),) * MAX_CANDIDATES, 1.0, 1.0, 0.1, 0.1),) * 5
    touch = Touch(
        2**62, 2**62, 2**62, LinkState.ENGAGED, TOUCH_BLOCK.to_bytes(block), ("n" * 40,) * 5, events, summaries
    )
    read = Touch.decode(touch.encode())
    assert (read.events, read.summaries) == (events, summaries)


def test_too_long_a_packet_is_neither_sent_nor_taken_and_a_refusal_has_its_longest() -> None:
    details = {"text": "x" * MAX_PACKET}
    with pytest.raises(BadPacket, match=f"longer than {MAX_PACKET}"):
        Request(1, 1, 1, "annotate", details).encode()
    with pytest.raises(BadPacket, match=f"longer than {MAX_PACKET}"):
        Request.decode(msgpack.packb([SCHEMA_VERSION, 1, 1, 1, "annotate", details]))
    with pytest.raises(BadPacket, match="refused"):
        Answer.decode(msgpack.packb([SCHEMA_VERSION, 1, 1, 1, "x" * 401, {}]))


@pytest.mark.parametrize("verb", ["", "Engage", "reboot", None, 3, ["engage"], b"engage"])
def test_an_unknown_verb_is_refused(verb: object) -> None:
    with pytest.raises(BadPacket, match=r"unknown request|field verb"):
        Request.decode(msgpack.packb([SCHEMA_VERSION, 1, 1, 1, verb, {}]))


@pytest.mark.parametrize("details", [None, [], {b"a": 1}, {"a": {"b": 1}}, {"a": [[1]]}, {"a": math.nan}, {"a": b"x"}])
@pytest.mark.parametrize("kind", [Request, Answer])
def test_details_are_a_flat_map_with_text_keys(kind: Any, details: object) -> None:
    with pytest.raises(BadPacket, match="details"):
        kind.decode(msgpack.packb([SCHEMA_VERSION, 1, 1, 1, "hello", details]))


@given(
    st.sampled_from(REQUESTS),
    st.integers(0, 2**63 - 1),
    st.dictionaries(st.text(max_size=9), st.text(max_size=9)),
    st.integers(-(2**63), 2**63 - 1),
)
def test_requests_and_heartbeats_come_back(verb: str, number: int, details: dict[str, str], offset_ns: int) -> None:
    request = Request(number, number, number, verb, details)
    assert Request.decode(request.encode()) == request
    beat = Heartbeat(1, 2, 3, LinkState.FAULT, 4, 5, offset_ns, number)
    assert Heartbeat.decode(beat.encode()) == beat
