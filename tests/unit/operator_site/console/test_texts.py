"""The words: exact ones of the design brief, their longest, and pseudonyms that are names."""

import pytest

from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.wire.messages import ThermalReason, ThermalStatus, explains
from common.wire.touch_summary import TouchSummary
from operator_site.console import texts
from operator_site.console.state.site_now import DEVICES
from tests.places import ROOT
from tests.unit.common.any_fault import examples


def test_alarms_say_where_what_and_what_to_do() -> None:
    assert texts.plate_over("index", 42.34) == "Index: plate 42.3 °C, over 42.0. Heat is off."
    hot = Fault(FaultCode.PLATE_TOO_HOT, "index", value=42.34, limit=42.0)
    assert texts.fault(hot) == "Index: plate 42.3 °C, over 42.0. Heat is off."
    assert texts.fault(hot._replace(needs_test=True)) == "Index: plate 42.3 °C, over 42.0. Engage for a plate test."
    swings = Fault(FaultCode.FORCE_SWINGS, "index", value=1.2, rate_hz=23.0)
    assert texts.fault(swings) == "Index: force swings 23 Hz, 1.2 N. Force is off."
    assert texts.remote_fault(swings) == "Remote index: force swings 23 Hz, 1.2 N. It stands still."
    stopped = Fault(FaultCode.REMOTE_STOP)
    assert texts.remote_fault(stopped) == "Remote site: emergency stop there. It stands still."
    unread = Fault(FaultCode.CONTAINED, detail="read: ValueError in " + "x" * 300)
    assert texts.fault(unread).startswith("Program error: read: ValueError in x")
    assert texts.plate_held("index", 42.0) == "Index: plate at 42.0 °C, held at its limit. Lift the finger."
    assert texts.link_slow(210.2, 8.1) == "Link slow: 210 ± 8 ms. Move slowly."
    assert texts.no_data(0.7) == "No data for 0.7 s. Screen is not live."
    assert texts.device_lost("ring") == "Ring module lost. Ring feels nothing."
    assert texts.device_absent("ring") == "Ring module absent."
    said = "STOP NOT CONFIRMED: Index, remote hand. Use the hardware switch."
    assert texts.not_confirmed(["index", "remote hand"]) == said
    assert texts.ended(761.0, 3, 0) == "Saved: 12 min 41 s, 3 findings, 0 messages lost."
    assert texts.ended(59.6, 1, 1) == "Saved: 1 min 0 s, 1 finding, 1 message lost."


def test_a_place_beside_the_middle_is_at_0_and_not_at_minus_0() -> None:
    assert texts.most_tender((-0.3, -5.2, 4.0), 2.04) == "most tender near x 0 y −5 mm, ± 4 mm; pain from about 2.0 N"


def test_no_alarm_is_longer_than_its_line() -> None:
    alarms = [texts.not_confirmed(DEVICES[:n]) for n in range(1, 8)]
    alarms += [texts.device_lost(name) for name in DEVICES]
    alarms += [texts.plate_held(name, 41.5) for name in FINGERS]
    alarms += [texts.site_slow(412.4, 500.0), texts.site_slow(None, "often")]
    alarms += [texts.LINK_LOST, texts.LINK_BACK, texts.MOTION_LOST, texts.DISK_FULL, texts.NOT_RECORDED]
    alarms += [texts.REMOTE_NOT_RECORDED, texts.CONSOLE_NOT_RECORDED]
    alarms += [texts.bus_trouble(name, "x" * 300) for name in DEVICES]
    assert [text for text in alarms if len(text) > texts.LONGEST_ALARM] == []


@pytest.mark.parametrize(
    ("status", "candidates", "probability", "line"),
    [
        (ThermalStatus.IDENTIFIED, (("pvc", 0.91),), 0.91, "PVC 91 %"),
        (ThermalStatus.IDENTIFIED, (("pvc", 0.994),), 0.994, "PVC 99 %"),
        (ThermalStatus.IDENTIFIED, (("pvc", 1.0),), 1.0, "PVC > 99 %"),
        (ThermalStatus.DECIDING, (("carbon_steel", 0.5),), 0.5, "carbon steel 50 %"),
        (ThermalStatus.AMBIGUOUS, (("pvc", 0.5), ("acrylic", 0.4)), 0.5, "PVC or acrylic"),
        (ThermalStatus.AMBIGUOUS, (("pvc", 0.9),), 0.9, "PVC 90 % or none calibrated"),
        (ThermalStatus.NO_CONTACT, (), 0.0, ""),
        (ThermalStatus.NONE, (), 0.0, ""),
    ],
)
def test_the_decision_is_said_with_how_sure_it_is(
    status: ThermalStatus, candidates: tuple[tuple[str, float], ...], probability: float, line: str
) -> None:
    best = candidates[0][0] if candidates else ""
    assert texts.decision(status, ThermalReason.NONE, best, TouchSummary(candidates), probability)[1] == line


def decision(status: ThermalStatus, reason: ThermalReason) -> str:
    return texts.decision(status, reason, "pvc", TouchSummary((("pvc", 0.4),)), 0.4)[1]


def test_why_nothing_is_named_is_said() -> None:
    reasons = [reason for reason in ThermalReason if explains(reason, ThermalStatus.UNIDENTIFIABLE)]
    lines = {reason: decision(ThermalStatus.UNIDENTIFIABLE, reason) for reason in reasons}
    assert len(set(lines.values())) == len(reasons) > 10
    assert lines[ThermalReason.NO_DIFFERENCE] == "no temperature difference"
    assert lines[ThermalReason.CONTACT_LOST] == "contact lost"
    assert lines[ThermalReason.STILL_WARM] == "spot still warm, touch beside it"
    assert lines[ThermalReason.SENSOR_OPEN] == "sensor open"
    assert lines[ThermalReason.NONE] == "no reason given"
    assert max(map(len, lines.values())) <= texts.LONGEST_ALARM
    assert decision(ThermalStatus.UNKNOWN, ThermalReason.NO_FIT) == "response fits no material"
    assert decision(ThermalStatus.UNKNOWN, ThermalReason.NOT_CALIBRATED) == "matches nothing calibrated"


@pytest.mark.parametrize("code", FaultCode)
def test_every_fault_is_an_alarm_that_names_its_place_its_value_and_its_limit(code: FaultCode) -> None:
    for fault in examples(code):
        for text in (texts.fault(fault), texts.remote_fault(fault)):
            assert len(text) <= texts.LONGEST_ALARM
            assert fault.where.lower() in text.lower()
            for number in (fault.value, fault.limit, fault.rate_hz):
                assert number is None or f"{number:.0f}" in text or f"{number:.1f}" in text or f"{number:.2f}" in text
            assert text[0].isupper()
            assert text.endswith((".", "…"))
        if fault.device and not fault.where:
            assert {"exoskeleton": "Exoskeleton", "telemanipulator": "Remote hand"}[fault.device] in texts.fault(fault)
            assert "Remote " in texts.remote_fault(fault)


STARTS, PATTERNS = {"access.py", "server.py"}, {"reporting.py", "texts.py"}
"""Of the console's own files and names: comments and hidden files, file names and pseudonyms."""


def test_the_console_reads_no_sentence() -> None:
    """No text of a site is taken apart: what the console decides upon is a code, a number or a flag."""
    for path in (ROOT / "operator_site" / "console").rglob("*.py"):
        code = path.read_text("utf-8")
        assert "startswith" not in code or path.name in STARTS, path.name
        assert "import re\n" not in code or path.name in PATTERNS, path.name


NUMBERS = ("P-0417", "A12", "STUDY 7", "2026-P3", "OR 2", "x1", "0417")
NAMES = ("Anna Meier", "Meier", "meier", "MEIER", "meier 7", "A. Schmidt", "Ἄννα Μαρία")
BIRTH_DATES = ("12.3.1961", "1961-03-12", "P 19610312")


@pytest.mark.parametrize("text", [*NUMBERS, *NAMES, *BIRTH_DATES])
def test_names_and_birth_dates_are_no_study_numbers(text: str) -> None:
    assert texts.looks_like_a_name(text) is (text not in NUMBERS)
