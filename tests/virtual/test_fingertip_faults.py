"""Each fault of a fingertip module is named, and its finger is neither burnt nor driven on."""

import re

import pytest

from common.faults.fault import FaultCode
from common.faults.texts import fault_text
from common.fingers import FINGERS
from common.limits import COMFORT, PLATE_FAULT_C, PLATE_PEAK_C, THERMAL_SAFE_S, WIDE, PlateRange
from tests.virtual.fingertip import Fingertip, fingertip
from tests.virtual.judge import LATE_S
from tests.virtual.session import COARSE_TICK_S

pytestmark = pytest.mark.long

HOTTEST_START_C = 40.0
STARTS = {
    # what is wanted first, for how long, and what is wanted when it breaks
    "at rest": (33.0, 2.0, 33.0),
    "at rest, then heated": (33.0, 2.0, 41.5),
    "at rest, then cooled": (33.0, 2.0, 15.0),
    "hot and heated": (39.9, 4.0, 41.5),
    "hot and held": (39.9, 6.0, 39.9),
    "hot, then cooled": (39.9, 4.0, 15.0),
    "cold and cooled": (21.0, 8.0, 15.0),
    "cold and held": (21.0, 8.0, 21.0),
    "cold, then heated": (21.0, 8.0, 41.5),
}
CORNERS = ("at rest, then heated", "hot and heated", "hot, then cooled", "cold, then heated")
"""Starts that every run of the long tests tries; the others are tried with the hardening."""
FAULTS = {
    # what is named, and after how long at the latest
    "reverse index": (r"index: plate temperature (does not follow|moves against) the drive", 2.0),
    "thermistor index open": (r"index: the plate's thermistor: open circuit", 0.1),
    "thermistor index short": (r"index: the plate's thermistor: short circuit", 0.1),
    "thermistor index frozen": (r"index: plate temperature .*(stands still|does not change)", 20.0),
}


def at(start: str, tip: Fingertip) -> float:
    """Bring the plate to where the fault will find it; returns what is wanted then, C."""
    first_c, seconds, goal_c = STARTS[start]
    tip.run(first_c, seconds, COARSE_TICK_S)
    assert tip.fault is None
    assert tip.plate_c == pytest.approx(first_c, abs=1.0)
    assert tip.plate_c <= HOTTEST_START_C
    tip.watch()
    return goal_c


def assert_not_burnt(tip: Fingertip) -> None:
    """The single-fault line of the limits, at the plate and at the skin on it."""
    assert max(tip.plate_peak_c, tip.skin_peak_c) <= PLATE_PEAK_C
    assert max(tip.plate_hot_s, tip.skin_hot_s) < 2.0
    assert tip.plate_c < PLATE_FAULT_C


@pytest.mark.parametrize(
    "start", [start if start in CORNERS else pytest.param(start, marks=pytest.mark.hardening) for start in STARTS]
)
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_and_latched_and_the_plate_is_not_driven(fault: str, start: str) -> None:
    named, within_s = FAULTS[fault]
    with fingertip() as tip:
        goal_c = at(start, tip)
        began_s = tip.time_s
        tip.simulation.faults.apply(fault)
        while tip.fault is None and tip.time_s - began_s < within_s:
            tip.run(goal_c, 0.1)
        tip.run(goal_c, 3.0)
        assert tip.fault is not None
        latched_s, fault_found = tip.fault
        assert re.match(named, fault_text(fault_found))
        assert latched_s - began_s <= within_s
        assert tip.driven_s - latched_s <= THERMAL_SAFE_S + LATE_S
        assert_not_burnt(tip)


@pytest.mark.parametrize("start", ["at rest, then cooled", "hot and heated", "cold, then heated"])
@pytest.mark.parametrize("fault", ["silence index tacttip", "unplug index tacttip"])
def test_a_silent_module_drives_nothing_and_is_missing(fault: str, start: str) -> None:
    with fingertip() as tip:
        goal_c = at(start, tip)
        began_s = tip.time_s
        tip.simulation.faults.apply(fault)
        tip.run(goal_c, 3.0)
        assert tip.driven_s - began_s <= THERMAL_SAFE_S + LATE_S
        assert tip.devices.missing().startswith("index tacttip: ")
        assert_not_burnt(tip)


def test_cooling_without_water_is_found_by_its_hot_side_long_before_that_can_heat_the_finger() -> None:
    with fingertip() as tip:
        tip.run(33.0, 2.0)
        began_s = tip.time_s
        tip.simulation.faults.apply("water index")
        tip.run(15.0, 60.0, COARSE_TICK_S)
        assert tip.fault is not None
        latched_s, fault_found = tip.fault
        assert (fault_found.code, fault_found.where) == (FaultCode.COOLING_LOST, "index")
        assert latched_s - began_s <= 20.0
        assert tip.driven_s - latched_s <= THERMAL_SAFE_S + COARSE_TICK_S
        assert_not_burnt(tip)


@pytest.mark.parametrize("lost_per_s", [0.015, 0.05, 0.2])
@pytest.mark.parametrize(("profile", "goal_c"), [(COMFORT, 38.0), (WIDE, 39.9)])
def test_a_thermistor_that_comes_off_is_found_by_the_heat_that_the_finger_takes(
    lost_per_s: float, profile: PlateRange, goal_c: float
) -> None:
    with fingertip(profile) as tip:
        tip.run(goal_c, 12.0, COARSE_TICK_S)
        tip.watch()
        tip.simulation.faults.apply(f"loosen index {lost_per_s}")
        while tip.fault is None and tip.time_s < 60.0:
            tip.run(goal_c, 0.1, COARSE_TICK_S)
        tip.run(goal_c, 3.0, COARSE_TICK_S)
        assert tip.fault is not None
        assert tip.fault[1].plate == FINGERS.index("index")
        assert tip.driven_s - tip.fault[0] <= THERMAL_SAFE_S + COARSE_TICK_S
        assert_not_burnt(tip)


@pytest.mark.parametrize("goal_c", [33.0, 39.5])
def test_a_plate_that_pumps_no_heat_into_its_hot_side_does_no_harm_without_water(goal_c: float) -> None:
    with fingertip() as tip:
        tip.run(goal_c, 4.0)
        tip.watch()
        tip.simulation.faults.apply("water index")
        tip.run(goal_c, 30.0, COARSE_TICK_S)
        assert tip.fault is None
        assert tip.plate_c == pytest.approx(goal_c, abs=0.5)
        assert_not_burnt(tip)
