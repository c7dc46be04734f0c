"""The words: exact ones of the design brief, their longest, and pseudonyms that are names."""

import pytest

from common.fingers import FINGERS
from common.wire.messages import ThermalStatus
from common.wire.touch_summary import TouchSummary
from operator_site.console import texts as words
from operator_site.console.state.site_now import DEVICES


def test_alarms_say_where_what_and_what_to_do() -> None:
    assert words.plate_over("index", 42.34) == "Index: plate 42.3 °C, over 42.0. Heat is off."
    assert words.fault("index: plate at 42.3 C, above 42.0 C") == "Index: plate 42.3 °C, over 42.0. Heat is off."
    assert words.fault("index: the force swings") == "Index: force not following. Force is off."
    assert words.plate_held("index", 42.0) == "Index: plate held at 42.0 °C limit. Lift the finger."
    assert words.link_slow(210.2, 8.1) == "Link slow: 210 ± 8 ms. Move slowly."
    assert words.no_data(0.7) == "No data for 0.7 s. Screen is not live."
    assert words.device_lost("ring") == "Ring module lost. Ring feels nothing."
    assert words.device_absent("ring") == "Ring module absent."
    assert words.not_confirmed(["index", "remote hand"]) == "STOP NOT CONFIRMED: Index, arm. Use the hardware switch."
    assert words.confirmed(7, 0.0912) == "STOPPED. All 7 devices confirmed in 0.09 s."
    assert words.saved(761.0, 3, 0) == "Saved: 12 min 41 s, 3 findings, 0 gaps."
    assert words.saved(59.6, 1, 1) == "Saved: 1 min 0 s, 1 finding, 1 gap."


def test_no_alarm_is_longer_than_its_line() -> None:
    texts = [words.not_confirmed(DEVICES[:n]) for n in range(1, 8)]
    texts += [words.device_lost(name) for name in DEVICES]
    texts += [words.plate_held(name, 41.5) for name in FINGERS]
    texts += [words.fault("middle: " + "x" * 300), words.fault("y" * 300), words.remote_fault("z" * 300)]
    texts += [words.LINK_LOST, words.LINK_BACK, words.DISK_FULL, words.NOT_RECORDED]
    texts += [words.REMOTE_NOT_RECORDED, words.CONSOLE_NOT_RECORDED]
    texts += [words.bus_trouble(name, "x" * 300) for name in DEVICES]
    assert [text for text in texts if len(text) > words.LONGEST_ALARM] == []


@pytest.mark.parametrize(
    ("status", "candidates", "probability", "line"),
    [
        (ThermalStatus.IDENTIFIED, (("pvc", 0.91),), 0.91, "PVC 91 %"),
        (ThermalStatus.IDENTIFIED, (("pvc", 0.999),), 0.999, "PVC > 99 %"),
        (ThermalStatus.DECIDING, (("carbon_steel", 0.5),), 0.5, "DECIDING carbon steel 50 %"),
        (ThermalStatus.AMBIGUOUS, (("pvc", 0.5), ("acrylic", 0.4)), 0.5, "AMBIGUOUS: PVC or acrylic"),
        (ThermalStatus.UNKNOWN, (), 0.2, "UNKNOWN: matches nothing calibrated"),
        (ThermalStatus.UNIDENTIFIABLE, (), 0.2, "CANNOT TELL"),
        (ThermalStatus.UNIDENTIFIABLE, (("pvc", 0.4), ("fat", 0.3)), 0.4, "CANNOT TELL"),
        (ThermalStatus.NO_CONTACT, (), 0.0, "NO CONTACT"),
        (ThermalStatus.NONE, (), 0.0, "NO CONTACT"),
    ],
)
def test_the_decision_is_said_with_how_sure_it_is(
    status: ThermalStatus, candidates: tuple[tuple[str, float], ...], probability: float, line: str
) -> None:
    best = candidates[0][0] if candidates else ""
    assert words.decision(status, best, TouchSummary(candidates), probability)[1] == line


def test_a_probability_is_never_certain() -> None:
    assert words.percent(1.0) == "> 99 %"
    assert words.percent(0.994) == "99 %"


NUMBERS = ("P-0417", "A12", "STUDY 7", "2026-P3", "OR 2", "x1", "0417")
NAMES = ("Anna Meier", "Meier", "meier", "MEIER", "meier 7", "A. Schmidt", "Ἄννα Μαρία")
BIRTH_DATES = ("12.3.1961", "1961-03-12", "P 19610312")


@pytest.mark.parametrize("text", [*NUMBERS, *NAMES, *BIRTH_DATES])
def test_names_and_birth_dates_are_no_study_numbers(text: str) -> None:
    assert words.looks_like_a_name(text) is (text not in NUMBERS)
