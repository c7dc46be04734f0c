"""Text of a peer is one log line of printable characters, of bounded length and rate."""

import json
import logging
import math
import sys
from collections.abc import Iterator

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from common.faults.fault import Fault, FaultCode
from common.files.printable import printable
from common.link.session_state import Session
from common.log_flood import AT_ONCE, PER_S, SAFETY_AT_ONCE, FloodFilter
from common.logs import JsonLines, TextLines

ANY_TEXT = st.text(st.characters(exclude_categories=()), max_size=200)
FORGED = "no\n12.000 remote INFO common.link.session_state: engaged\x1b[2J\u202e"


class Kept(logging.Handler):
    """A handler with the flood filter of a process, on a clock that a test sets."""

    def __init__(self) -> None:
        super().__init__()
        self.now_s = 100.0
        self.lines: list[str] = []
        self.setFormatter(TextLines("remote"))
        self.addFilter(FloodFilter(lambda: self.now_s))

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(self.format(record))


@pytest.fixture
def kept() -> Iterator[Kept]:
    handler = Kept()
    root = logging.getLogger()
    before = root.level
    root.addHandler(handler)
    root.setLevel(logging.INFO)
    yield handler
    root.removeHandler(handler)
    root.setLevel(before)


def record(message: str, *arguments: object, **extra: object) -> logging.LogRecord:
    return logging.makeLogRecord({"name": "a.b", "levelname": "INFO", "msg": message, "args": arguments, **extra})


@given(
    ANY_TEXT,
    st.none() | st.floats() | ANY_TEXT | st.binary() | st.integers() | st.just(10**5000) | st.lists(st.integers()),
)
@example(FORGED, FORGED)
def test_any_record_is_one_printable_line_and_any_json_is_strict(text: str, value: object) -> None:
    for line in (
        TextLines("remote").format(record("%s", text, context=value)),
        JsonLines("remote").format(record("%s", text, context=value)),
    ):
        assert line.isprintable()
        line.encode("utf-8")
    logged = json.loads(line)
    assert logged["message"] == printable(text)
    assert json.loads(json.dumps(logged, allow_nan=False)) == logged
    if isinstance(value, float) and not math.isfinite(value):
        assert logged["context"] == str(value)


@pytest.mark.parametrize("lines", [TextLines("remote"), JsonLines("remote")])
def test_a_line_of_any_length_is_cut(lines: logging.Formatter) -> None:
    try:
        raise ValueError("y" * 10**6 + "\n\x1b[2J")
    except ValueError:
        line = lines.format(record("%s", "x" * 10**6, exc_info=sys.exc_info(), context="z" * 10**6))
    assert line.isprintable()
    assert len(line) <= 30_000
    assert "ValueError" in line


def test_two_alternating_refusals_are_few_lines_and_the_rest_is_counted(kept: Kept) -> None:
    def refuse(verb: str) -> None:
        logging.getLogger("a").warning("refused %s", verb)

    for n in range(8_000):
        kept.now_s += 0.001
        refuse("engage" if n % 2 else "hello")
    assert AT_ONCE <= len(kept.lines) <= AT_ONCE + 8 * PER_S + 1
    assert sum(map(len, kept.lines)) < 10_000
    kept.now_s += 10.0 / PER_S
    refuse("engage")
    left_out = sum(int(line.split("(")[1].split()[0]) for line in kept.lines if "similar lines omitted)" in line)
    assert left_out + len(kept.lines) == 8_001


def test_another_place_of_the_program_is_logged_during_a_flood(kept: Kept) -> None:
    log = logging.getLogger("a")
    for _ in range(1_000):
        log.warning("refused")
    log.warning("the loop is behind")
    assert "the loop is behind" in kept.lines[-1]


def test_messages_made_of_the_far_sides_text_share_their_places_bound(kept: Kept) -> None:
    for n in range(5_000):
        logging.getLogger("a").warning(f"refused {n}")
    assert len(kept.lines) == AT_ONCE


def test_safety_events_are_logged_after_any_flood_of_others(kept: Kept) -> None:
    session = Session()
    session.connect(7)
    for n in range(2_000):
        session.equipped(f"missing {n}")
    for _ in range(40):
        session.engage()
        session.latch(Fault(FaultCode.OPERATOR_STOP))
        session.clear()
    assert sum("fault: emergency stop by the operator" in line for line in kept.lines) == 40
    assert sum("engaged" in line for line in kept.lines) == 40
    for _ in range(1_000):
        session.engage()
        session.disengage("asked")
    assert sum(": engaged" in line for line in kept.lines) == SAFETY_AT_ONCE


def test_texts_of_a_session_are_printable() -> None:
    session = Session()
    session.connect(7, FORGED)
    session.engage(FORGED)
    session.disengage(FORGED)
    session.latch(Fault(FaultCode.CONTAINED, FORGED, FORGED, detail=FORGED))
    assert session.paused.isprintable()
    assert session.fault is not None
    assert all(text.isprintable() for text in (*session.fault[:3], session.fault.detail))
    assert all(happening.text.isprintable() for happening in session.take_happenings())
