"""Packets that decoders accept and a correct site never sends, as hypothesis draws them."""

import os
from typing import Any

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from common.link.capabilities import capabilities
from common.wire.messages import EVENT_MAX, MAX_EVENTS, MOTION_BLOCK, TOUCH_BLOCK, Event, EventKind, explains
from common.wire.packets import MAX_INTEGER, MAX_TEXT, FingerBlock, LinkState, N
from common.wire.session_messages import REQUESTS
from common.wire.touch_summary import NO_SUMMARIES, TouchSummary

MS = 1_000_000
SEQUENCES = int(os.environ.get("SEQUENCES", "500"))
"""Sequences tried with each site; `make hardening SEQUENCES=100000` takes hours."""
STEPS = 20
FUZZ = settings(max_examples=SEQUENCES, stateful_step_count=STEPS, derandomize=SEQUENCES == 500, deadline=None)

integers = st.one_of(st.sampled_from([0, 1, 2, MAX_INTEGER, MAX_INTEGER - 1, 2**62]), st.integers(0, MAX_INTEGER))
states = st.sampled_from(LinkState)
texts = st.one_of(st.just(""), st.sampled_from(["pine", "aluminium", "pvc"]), st.text(max_size=MAX_TEXT))
gaps_ms = st.sampled_from([2, 2, 2, 2, 10, 40, 80, 150, 1200, -1000])
"""Between two ticks; the clock may be set back."""
plain = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**63), 2**64 - 1),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=300),
    st.lists(st.one_of(st.none(), st.integers(-5, 5), st.text(max_size=5)), max_size=5),
)
FIELDS = ("session", "max_age_s", "fault", "after_s", "unconfirmed", "calibration", "calibrated", "fingers", "rate_hz")
KNOWN = (*FIELDS, "layout", "schema", "role", "text", "seen", "state", "materials", "recording")
details = st.dictionaries(st.one_of(st.sampled_from(KNOWN), st.text(max_size=8)), plain, max_size=6)
verbs = st.sampled_from(REQUESTS)


def able(fingers: tuple[str, ...], rate_hz: float = 500.0) -> dict[str, Any]:
    """What an honest far side says of itself."""
    return capabilities(fingers, rate_hz, max_age_s=0.15)


@st.composite
def blocks(draw: st.DrawFn, block: FingerBlock, codes: tuple[str, ...] = ()) -> bytes:
    """Bytes of a block with values at the limits of their columns, tiny ones, and some between."""
    kinds = draw(st.lists(st.integers(0, 5), min_size=len(block.names), max_size=len(block.names)))
    low, high = block.low.astype(np.float64), block.high.astype(np.float64)
    choices = [low, high, np.clip(0.0, low, high), np.clip(1e-45, low, high), (low + high) / 2, np.clip(1.0, low, high)]
    row = np.array([choices[kind][column] for column, kind in enumerate(kinds)])
    rows = np.tile(row, (N, 1))
    other = draw(st.integers(0, N - 1))
    rows[other] = choices[draw(st.integers(0, 5))]
    for code in codes:
        rows[:, block.names.index(code)] = np.floor(rows[:, block.names.index(code)])
    if "thermal_reason" in codes:
        status, reason = (block.names.index(name) for name in ("thermal_status", "thermal_reason"))
        rows[:, reason] *= [explains(int(row[reason]), int(row[status])) for row in rows]
    return block.to_bytes(np.clip(rows.astype(np.float32), block.low, block.high))


motion_blocks = blocks(MOTION_BLOCK)
touch_blocks = blocks(TOUCH_BLOCK, ("mode", "contact", "thermal_status", "thermal_reason"))
events = st.builds(
    Event,
    st.one_of(st.integers(0, 20), integers),
    st.sampled_from(EventKind),
    st.integers(0, N - 1),
    integers,
    integers,
    st.sampled_from([0.0, 1e-300, 0.1, 300.0, EVENT_MAX]),
    texts,
)
late_ms = st.integers(-5, 60)
"""How long ago the hand was where an event is, ms, for those that are to wait."""
event_lists = st.lists(st.tuples(events, st.one_of(st.none(), late_ms)), max_size=MAX_EVENTS // 4)
materials = st.tuples(*[texts] * N)
summaries = st.one_of(
    st.just(NO_SUMMARIES),
    st.just((TouchSummary((("", 1.0), ("x" * MAX_TEXT, 0.0)), 100.0, 0.0, 0.1, None),) * N),
)
