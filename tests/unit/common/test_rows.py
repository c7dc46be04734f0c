"""Rows of fingers in packets: one definition gives names, ranges and bytes of columns, and tables of the document."""

import numpy as np
import pytest

from common.fingers import FINGERS
from common.wire.messages import (
    NO_TOUCH,
    TOUCH_BLOCK,
    Motion,
    MotionRow,
    Touch,
    TouchRow,
    columns,
    motion_packet,
    pack_hand,
    pack_rows,
)
from common.wire.packets import LinkState
from tests.conftest import PROTOCOLS

N = len(FINGERS)


@pytest.mark.parametrize("row", [MotionRow, TouchRow])
def test_the_documents_table_is_the_definition(row: type[MotionRow] | type[TouchRow]) -> None:
    lines = ["| column | field | range | unit | meaning |", "|---|---|---|---|---|"]
    for number, (name, column) in enumerate(columns(row).items()):
        lines.append(f"| {number} | {name} | {column.low:g}..{column.high:g} | {column.unit} | {column.meaning} |")
    assert "\n\n" + "\n".join(lines) + "\n\n" in PROTOCOLS.read_text("utf-8")


def test_the_rows_of_a_touch_come_back_by_name() -> None:
    rows = tuple(NO_TOUCH._replace(object_c=20.0 + finger, contact=1.0) for finger in range(N))
    touch = Touch(1, 1, 1, LinkState.ENGAGED, pack_rows(rows), ("",) * N, ())
    assert Touch.decode(touch.encode()).rows == rows
    assert np.array_equal(touch.block, np.array(rows, np.float32))


def test_the_rows_of_a_motion_come_back_by_name() -> None:
    rows = tuple(MotionRow(0.25, -0.5, 2.0**-finger * 1e-2) for finger in range(N))
    packet = Motion(1, 1, 1, LinkState.ENGAGED, rows).encode()
    assert np.array_equal(Motion.decode(packet).rows, np.array(rows, np.float32))
    assert packet == motion_packet(1, 1, 1, LinkState.ENGAGED, pack_hand(0.25, -0.5, [row.z_m for row in rows]))


def test_a_finger_that_is_not_in_use_is_zeros() -> None:
    assert TOUCH_BLOCK.check(pack_rows([NO_TOUCH] * N)) == bytes(4 * N * len(NO_TOUCH))
