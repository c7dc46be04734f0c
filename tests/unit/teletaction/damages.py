"""A short recording of everything that a session records, and many ways to damage it, the same ones every time."""

import random
import struct
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import msgpack
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from common.faults.fault import Fault, FaultCode
from operator_site.console.examination.journal import SCHEMAS as KEPT
from operator_site.site_recording import SCHEMAS as OPERATOR
from remote_site.site_recording import SCHEMAS as REMOTE
from sim_sensors.truth_log import OPERATOR_STREAMS, REMOTE_STREAMS
from tests.places import GOLDEN
from tests.unit.teletaction.held_recordings import Message, held

SECONDS = 0.9
MAGIC_BYTES = 8
_SCHEMAS = {"operator": OPERATOR, "remote": REMOTE, "console": KEPT, "truth": OPERATOR_STREAMS | REMOTE_STREAMS}
Change = Callable[[Message], Message | None]
"""Of one message; None leaves it out."""


def messages() -> list[Message]:
    """Some of the golden recording, and beside it one or more messages of every other stream."""
    golden = held(GOLDEN)
    start_ns = golden[len(golden) // 5][1]  # the contact is in it
    kept = [m for m in golden if start_ns <= m[1] < start_ns + SECONDS * 1e9]
    made = [
        (stream, start_ns + round(at_s * 1e9), msgpack.packb(content)) for stream, at_s, content in _others(start_ns)
    ]
    return sorted(kept + made, key=lambda message: message[1])


def _others(start_ns: int) -> Iterator[tuple[str, float, Any]]:
    five, whole, zero_s = [1.0] * 5, [1] * 5, start_ns * 1e-9
    fingertips = dict.fromkeys(("motor_rpm", "plate_c", "hot_side_c", "peltier", "surface_c"), five)
    fingertips |= {"motor_mv": whole, "felt_c": five, "force_n": five, "z_m": five, "x_m": 0.0, "y_m": 0.0}
    contact = {"mode": whole, "object": whole, "force_n": five, "plate_c": five, "heater": five, "z_m": five}
    for at_s in (0.1 * n for n in range(int(SECONDS / 0.1))):
        yield "truth_fingertips", at_s, {**fingertips, "script_mode": 1, "act": "press", "object": "block"}
        yield "truth_contact", at_s, {**contact, "x_m": 0.0, "y_m": 0.0}
        yield "remote/gate", at_s, [0.0, 0.0, five, five, whole, None]
        yield "remote/thermal", at_s, [1, 3, "pvc", 0.9, 22.0, 0.3, None, None, None, None, 0.1, None]
        yield "operator/skin", at_s, [five, five, five]
        yield "operator/clock", at_s, [0, 900_000, 46_000_000]
    event = {"object": "block", "object_c": 22.0, "material": "pvc", "approach_m_s": 0.05, "mode": 1}
    yield "truth_event", 0.2, {**event, "finger": 1, "kind": "contact"}
    yield "truth_event", 0.7, {**event, "finger": 1, "kind": "release"}
    yield "truth_motor", 0.21, {"finger": 1, "motor_mv": 700}
    yield "remote/event", 0.2, [1, 0, 1, start_ns + 200_000_000, 0.5, ""]
    yield "operator/played", 0.21, [1, 0, 1]
    yield "remote/session", 0.01, ["connected", 7, "operator", None]
    yield "operator/session", 0.02, ["connected", 7, "remote", None]
    yield "operator/session", 0.8, ["fault", 7, "", Fault(FaultCode.FORCE_SWINGS, "index", value=1.2, rate_hz=23.0)]
    yield "operator/figures", 0.3, {"devices": {"index tacttip": {"serial": "TT1", "times_lost": 0}}, "recorded": {}}
    begun = {"pseudonym": "P-0417", "wall_clock": "2026-11-23T14:07:03+01:00", "who": "OR-1", "sides": {"top": "head"}}
    yield "console/session", 0.03, {"what": "begin", "at_s": zero_s, **begun}
    finding = {"kind": "warm", "finger": "index", "x_m": 0.01, "y_m": 0.0, "text": "warm", "compare": "", "note": ""}
    yield "console/finding", 0.5, {"id": 1, "at_s": zero_s + 0.4, **finding}
    yield "console/alarm", 0.6, {"id": "plate", "since_s": zero_s, "priority": "high", "text": "x", "ended_s": None}
    yield "console/act", 0.6, {"at_s": zero_s, "who": "OR-1", "verb": "estop", "details": {}, "ok": True, "answer": ""}


def write(
    out: Path,
    content: list[Message],
    compression: CompressionType = CompressionType.NONE,
    *,
    data_crcs: bool = True,
    configuration: str | None = None,
) -> Path:
    """A merged recording of these messages with the golden one's tables; `configuration` in place of its own."""
    with GOLDEN.open("rb") as file, out.open("wb") as written:
        golden = make_reader(file)
        writer = Writer(written, 40_000, compression, enable_data_crcs=data_crcs)
        writer.start(profile="teletaction", library="teletaction")
        for entry in golden.iter_metadata():
            facts = {**entry.metadata, **({} if configuration is None else {"configuration": configuration})}
            writer.add_metadata(entry.name, facts)
        for table in golden.iter_attachments():
            writer.add_attachment(0, 0, table.name, table.media_type, table.data)
        channels: dict[str, int] = {}
        for stream, time_ns, payload in content:
            if stream not in channels:
                origin = stream.split("/")[0] if "/" in stream else "sim"
                schema = writer.register_schema(stream, "jsonschema", b"{}")
                channels[stream] = writer.register_channel(stream, "msgpack", schema, {"recording": origin})
            writer.add_message(channels[stream], time_ns, payload, time_ns)
        writer.finish()  # type: ignore[no-untyped-call]
    return out


class Record(NamedTuple):
    """Where one stands in a file: opcode, first byte, bytes with its head of nine."""

    opcode: int
    offset: int
    length: int


def records(whole: bytes) -> list[Record]:
    """All of a sound file."""
    found, offset = [], MAGIC_BYTES
    while offset < len(whole) - MAGIC_BYTES:
        opcode, length = struct.unpack_from("<BQ", whole, offset)
        found.append(Record(opcode, offset, 9 + length))
        offset += 9 + length
    return found


def in_the_file(whole: bytes, seed: int) -> Iterator[tuple[str, bytes]]:
    """Damage as a disk or a copy does it: bits, lengths, ranges, missing ends."""
    choose = random.Random(seed)
    found = records(whole)
    kinds = sorted({record.opcode for record in found})

    def changed(offset: int, *new: int) -> bytes:
        return whole[:offset] + bytes(new) + whole[offset + len(new) :]

    for opcode in kinds:
        record = choose.choice([record for record in found if record.opcode == opcode])
        for place, offset in (
            ("opcode", record.offset),
            ("length", record.offset + 1),
            ("beginning", record.offset + 9 + choose.randrange(min(8, record.length - 9))),
            ("content", record.offset + 9 + choose.randrange(record.length - 9)),
            ("end", record.offset + record.length - 1),
        ):
            bit = 1 << choose.randrange(8)
            yield f"bit in {place} of opcode {opcode}", changed(offset, whole[offset] ^ bit)
        for length in (0, 2**40, 2**63, 2**64 - 1):
            yield f"opcode {opcode} of {length} bytes", changed(record.offset + 1, *struct.pack("<Q", length))
    for turn in range(6):
        end = choose.randrange(len(whole))
        yield f"cut {turn}", whole[:end]
        start = choose.randrange(len(whole))
        yield f"zeros {turn}", changed(start, *bytes(min(choose.choice((1, 64, 4096)), len(whole) - start)))
        start = choose.randrange(len(whole))
        yield f"junk {turn}", changed(start, *choose.randbytes(min(64, len(whole) - start)))
        start = choose.randrange(len(whole))
        yield f"missing bytes {turn}", whole[:start] + whole[start + 100 :]
    chunk = choose.choice([record for record in found if record.opcode == 6])
    content = whole[chunk.offset : chunk.offset + chunk.length]
    yield "chunk twice", whole[: chunk.offset] + content + whole[chunk.offset :]
    yield "chunk missing", whole[: chunk.offset] + whole[chunk.offset + chunk.length :]
    yield "something after the end", whole + b"more"
    yield "twice", whole + whole
    yield "magic at the end", changed(len(whole) - 1, 0)


def in_messages(content: list[Message], seed: int) -> Iterator[tuple[str, list[Message]]]:
    """Damage before the file was written: every checksum is right."""
    choose = random.Random(seed)
    for stream in sorted({message[0] for message in content}):
        places = [n for n, message in enumerate(content) if message[0] == stream]
        for name, change in _CHANGES.items():
            number = choose.choice(places)
            _, time_ns, payload = content[number]
            damaged = change(choose, payload)
            yield f"{name} in {stream}", [*content[:number], (stream, time_ns, damaged), *content[number + 1 :]]
    for time_ns in (0, 2**63, 2**64 - 1):
        number = choose.randrange(len(content))
        stream, _, payload = content[number]
        yield f"time {time_ns}", [*content[:number], (stream, time_ns, payload), *content[number + 1 :]]


def _flipped(choose: random.Random, payload: bytes) -> bytes:
    place = choose.randrange(len(payload))
    return payload[:place] + bytes([payload[place] ^ 1 << choose.randrange(8)]) + payload[place + 1 :]


def _replaced(choose: random.Random, payload: bytes, by: Any) -> bytes:
    """One field is something else."""
    fields = msgpack.unpackb(payload)
    if isinstance(fields, dict):
        return msgpack.packb({**fields, choose.choice(sorted(fields)): by})  # type: ignore[no-any-return]
    place = choose.randrange(len(fields))
    return msgpack.packb([*fields[:place], by, *fields[place + 1 :]])  # type: ignore[no-any-return]


_CHANGES: dict[str, Callable[[random.Random, bytes], bytes]] = {
    "bit": _flipped,
    "half": lambda _, payload: payload[: len(payload) // 2],
    "nothing": lambda *_: b"",
    "number": lambda *_: b"\x03",
    "text field": partial(_replaced, by="<b>x</b>"),
    "infinite field": partial(_replaced, by=float("inf")),
    "huge field": partial(_replaced, by=2**63 - 1),
    "list field": partial(_replaced, by=[[], {}]),
    "length of a list": lambda *_: b"\xdd\xff\xff\xff\xff",
}
