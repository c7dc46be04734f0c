"""Reads the truth at the simulated devices of a session, for tests to judge."""

import math
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgpack
from mcap.exceptions import EndOfFile
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from common.fingers import FINGERS
from robustness.fault_judge import Floats, Truth
from robustness.fault_table import FREE, STROKING
from robustness.faults import read_truth

__all__ = ["FELT_N", "HEATS", "LATE_S", "STROKES", "Floats", "Truth", "between", "packets", "read_truth", "written"]

STROKES, HEATS = FINGERS.index(STROKING), FINGERS.index(FREE)
"""The finger that strokes an object, and the one in the air whose sensor is heated."""
LATE_S = 0.030
"""What the machine may add to a hold time: a log entry every 10 ms, and a scheduler that others use too."""
FELT_N = 0.15
"""Least force that counts as being felt."""


def between(time_s: Floats, values: Floats, from_s: float, to_s: float) -> Floats:
    """The values written down in from_s..to_s, of which there must be some."""
    found = values[(time_s > from_s) & (time_s < to_s)]
    assert len(found), f"nothing was written down from {from_s} s to {to_s} s"
    return found


def written(
    path: Path, stream: str, from_s: float = -math.inf, to_s: float = math.inf, *, may_be_cut: bool = False
) -> list[tuple[float, Any]]:
    """What a process wrote into one stream in from_s..to_s, and when, s; `may_be_cut` as for `packets`."""
    found = packets(path, stream, may_be_cut=may_be_cut)
    return [(time_s, msgpack.unpackb(packet)) for time_s, packet in found if from_s <= time_s < to_s]


def packets(path: Path, stream: str, *, may_be_cut: bool = False) -> list[tuple[float, bytes]]:
    """The packets of one stream, and when each was written, s.

    A recording may be cut where its process was killed, or was given no time by a busy machine; elsewhere it is whole.
    """
    topics: dict[int, str] = {}
    found = []
    with path.open("rb") as file, suppress(*([EOFError, EndOfFile] if may_be_cut else [])):
        for record in StreamReader(file).records:
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Message) and topics[record.channel_id] == stream:
                found.append((record.log_time * 1e-9, record.data))
    return found
