"""Faults: each code has a text and a source, and packed faults are read back, also false ones of a peer."""

import json
import math
import re
from string import Formatter
from typing import Any

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.faults.fault import (
    AXES,
    EXOSKELETON,
    LONGEST_DETAIL,
    OF_A_PLATE,
    TELEMANIPULATOR,
    UNITS,
    Fault,
    FaultCode,
    read_fault,
)
from common.faults.texts import _FAULTS, fault_figures, fault_text, said_fault, thermal_text
from common.fingers import FINGERS
from common.wire.messages import THERMAL_REASONS, ThermalReason, ThermalStatus, explains
from common.wire.packets import MAX_TEXT, BadPacket
from common.wire.session_messages import Answer
from tests.places import ROOT
from tests.unit.common.any_fault import LARGE, examples, faults

PRODUCT = [path for room in ("common", "remote_site", "operator_site") for path in sorted((ROOT / room).rglob("*.py"))]
PROTOCOLS = (ROOT / "docs" / "protocols.md").read_text("utf-8")


@given(faults)
def test_a_fault_is_read_back_from_packets_recordings_and_status_files(fault: Fault) -> None:
    assert read_fault(msgpack.unpackb(msgpack.packb(fault))) == fault
    assert read_fault(json.loads(json.dumps(fault_figures(fault)))) == fault
    details = Answer.decode(Answer(1, 2, 3, "", {"fault": fault}).encode()).details
    assert read_fault(details["fault"]) == fault
    assert fault.bounded() == fault
    assert said_fault(list(fault)) == fault_text(fault)
    assert fault_text(fault).isprintable()


def test_no_fault_is_read_back_as_none_and_has_no_words() -> None:
    assert read_fault(None) is None
    assert fault_figures(None) is None
    assert (fault_text(None), said_fault(None)) == ("", "")


@given(st.text(max_size=LONGEST_DETAIL))
def test_an_unknown_code_is_an_unknown_fault(code: str) -> None:
    found = read_fault([code, "index", "", 1.0, 2.0, None, "", False])
    assert found is not None
    if code not in set(FaultCode):
        assert found.code is FaultCode.UNKNOWN
        assert fault_text(found).startswith("index: unknown fault")
        assert found.detail.isprintable()


@pytest.mark.parametrize(
    "said",
    [
        "plate too hot",
        7,
        [],
        {},
        ["plate-too-hot"],
        [7, "index", "", None, None, None, "", False],
        ["plate-too-hot", None, "", None, None, None, "", False],
        ["plate-too-hot", "index", 1, None, None, None, "", False],
        ["plate-too-hot", "index", "", "43", None, None, "", False],
        ["plate-too-hot", "index", "", 43, None, None, "", False],
        ["plate-too-hot", "index", "", math.nan, None, None, "", False],
        ["plate-too-hot", "index", "", None, math.inf, None, "", False],
        ["plate-too-hot", "index", "", None, None, None, b"", False],
        ["plate-too-hot", "index", "", None, None, None, "", 0],
    ],
)
def test_a_value_of_another_type_is_an_unknown_fault(said: Any) -> None:
    with pytest.raises(BadPacket, match="fault: "):
        read_fault(said)
    assert said_fault(said) == "unknown fault"


def test_every_reader_takes_a_fault_once_it_is_bounded() -> None:
    wild = Fault(FaultCode.CONTAINED, "\x1b" * 99, "y\n" * 99, math.nan, math.inf, -math.inf, "z\r" * 999)
    fault = wild.bounded()
    assert read_fault(list(fault)) == fault
    assert (len(fault.where), len(fault.detail)) == (MAX_TEXT, LONGEST_DETAIL)
    assert fault[3:6] == (None, None, None)


@pytest.mark.parametrize("code", FaultCode)
def test_every_code_has_words_with_its_numbers_and_is_found_somewhere(code: FaultCode) -> None:
    for fault in examples(code):
        text = fault_text(fault)
        assert fault.device in text
        assert fault.where in text
        for number in (fault.value, fault.limit):
            assert number is None or f"{number:.0f}" in text.replace(f"{number:.1f}", f"{number:.0f}")
    named = {name for _, name, _, _ in Formatter().parse(_FAULTS[code]) if name}
    assert named <= {"value", "limit", "rate_hz", "detail"}
    assert ("value" in named) == (code in UNITS)
    tables = {"texts.py"} if code in (FaultCode.CONTAINED, FaultCode.UNKNOWN) else {"texts.py", "fault.py"}
    found = {path.name for path in PRODUCT if f"FaultCode.{code.name}" in path.read_text("utf-8")}
    assert found - tables, "nothing finds it"


def test_a_number_that_is_not_known_is_a_question_mark() -> None:
    assert fault_text(Fault(FaultCode.PLATE_TOO_HOT, "index")) == "index: plate at ? C, above ? C"


def test_a_repeated_fault_says_that_its_plate_stays_off() -> None:
    text = fault_text(Fault(FaultCode.COOLING_LOST, "index", value=31.0, limit=20.0, needs_test=True))
    assert text == (
        "index: the cooling water is lost: hot side at 31 C, 20 C before; "
        "again within 10 min: this plate stays off until a small test pulse has moved it"
    )


@pytest.mark.parametrize("code", FaultCode)
def test_a_fault_is_of_a_plate_only_where_it_names_a_finger(code: FaultCode) -> None:
    for number, finger in enumerate(FINGERS):
        assert Fault(code, finger).plate == (number if code in OF_A_PLATE else None)
    for where in (*AXES, "", "HandPose", EXOSKELETON, TELEMANIPULATOR):
        assert Fault(code, where).plate is None


def test_the_document_has_every_code_with_its_unit() -> None:
    table = PROTOCOLS.split("| thermal_reason | name |")[1]
    rows = re.findall(r"^\| (\d+) \| ([a-z-]+) \| ([\d, ]+|any)", table, re.MULTILINE)
    for reason, (number, name, statuses) in zip(ThermalReason, rows, strict=False):
        assert (reason, reason.code or "none") == (int(number), name)
        explained = [int(status) for status in ThermalStatus if explains(reason, status)]
        assert statuses == "any" if not reason else explained == [int(status) for status in statuses.split(", ")]


@pytest.mark.parametrize("reason", ThermalReason)
def test_every_thermal_reason_has_words_and_is_found_somewhere(reason: ThermalReason) -> None:
    assert THERMAL_REASONS[reason.code] is reason
    assert bool(thermal_text(reason)) == bool(reason)
    found = [path.name for path in PRODUCT if f"ThermalReason.{reason.name}" in path.read_text("utf-8")]
    assert set(found) - {"texts.py", "messages.py"}, "nothing gives it"


def test_large_numbers_are_still_bounded() -> None:
    assert len(msgpack.packb(LARGE)) < 700
