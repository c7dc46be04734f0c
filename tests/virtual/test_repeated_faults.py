"""A plate that faults again and again: clearing and engaging again must not drive it each time."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.limits import PLATE_PEAK_C, WIDE
from common.safety.repeated_fault import REPEATED_S, TEST_EVERY_S
from common.wire.packets import N
from operator_site.devices.ntc import PlateSensor
from operator_site.safety.gated_output import Outputs
from operator_site.safety.limit_flags import Limit
from operator_site.safety.operator_gate import TEST_DRIVE, OperatorGate
from operator_site.safety.sampled_wall import SampledWall
from operator_site.thermal.plates import PlateController
from sim_sensors.devices.breakable_parts import Thermistor
from sim_sensors.devices.tacttip import ntc_counts
from sim_sensors.physics.finger_plate import FingerPlates
from tests.virtual.session import COARSE_TICK_S

pytestmark = pytest.mark.long

BAD, SOUND = FINGERS.index("index"), FINGERS.index("middle")
CLEARED_AFTER_S = 1.0
TURNS_C = (15.0, 41.5)
HELD_S = 5.0
"""What is wanted of the plates, by turns, each for this long."""
FIRST_TWO_S = 8.0
"""Full drive of two faults at most, before the second latches, s: 3 s each to find a reading that stands still."""
RISE_K = 0.4


class Hand:
    """Five fingertips on their plates and the gate; a person clears every fault and engages again.

    Attributes:
        time_s: virtual time.
        driven_s: integral of each plate's drive without its sign, s of full drive.
        faults: what was latched, one entry a latch.
        output: the newest.
    """

    def __init__(self, goals_c: tuple[float, ...], noise_k: float = 0.01) -> None:
        self.goals_c = goals_c
        self.plates = FingerPlates(N, 0, noise_k)
        self.thermistors = [Thermistor() for _ in range(N)]
        self.gate = OperatorGate(WIDE, SampledWall(2.0, COARSE_TICK_S))
        self.time_s = 0.0
        self.driven_s = np.zeros(N)
        self.faults: list[str] = []
        self.reset_peaks()
        self._sensors = [PlateSensor() for _ in range(N)]
        self._loops = [PlateController() for _ in range(N)]
        self._set_c = [33.0] * N
        self._drive = np.zeros(N)
        self._cleared_s = math.inf

    def reset_peaks(self) -> None:
        """Restart the peaks."""
        self.plate_peak_c, self.skin_peak_c = self.plates.plate_c.copy(), self.plates.surface_c.copy()

    def run(self, seconds: float) -> None:
        """Want one goal after the other, each for some seconds."""
        for _ in range(round(seconds / COARSE_TICK_S)):
            self._tick()

    def _tick(self) -> None:
        self.time_s = now_s = self.time_s + COARSE_TICK_S
        self.plates.step(COARSE_TICK_S, self._drive)
        counts = [
            each.read(ntc_counts(c)) for each, c in zip(self.thermistors, self.plates.ntc_c.tolist(), strict=True)
        ]
        read = [sensor.step(now_s, each) for sensor, each in zip(self._sensors, counts, strict=True)]
        for finger, each in enumerate(read):
            if each.fault:
                self.gate.trip(Fault(each.fault, FINGERS[finger]))
        goal_c = self.goals_c[int(now_s / HELD_S) % len(self.goals_c)]
        wanted = []
        for finger, loop in enumerate(self._loops):
            if self.gate.fault or self.gate.undriven[finger]:
                loop.reset()
            wanted.append(loop.step(now_s, self._set_c[finger], read[finger].plate_c))
        self.output = self.gate.step(
            now_s,
            True,
            0.0,
            Outputs([0.0] * N, [0.0] * N, [goal_c] * N, wanted, [0] * N),
            plate_measured_c=[each.plate_c for each in read],
            measurement_age_s=[0.0] * N,
            z_m=[0.0] * N,
            height_age_s=0.0,
        )
        self._set_c = self.output.plate_set_c
        if self.output.fault is not None and self._cleared_s == math.inf:
            self.faults.append(self.output.fault)
            self._cleared_s = now_s + CLEARED_AFTER_S
        if now_s >= self._cleared_s:
            self._cleared_s = math.inf
            self.gate.clear_fault()
        self._drive = np.array(self.output.peltier_drive)
        self.driven_s += COARSE_TICK_S * np.abs(self._drive)
        np.maximum(self.plate_peak_c, self.plates.plate_c, out=self.plate_peak_c)
        np.maximum(self.skin_peak_c, self.plates.surface_c, out=self.skin_peak_c)


def reverse(hand: Hand) -> None:
    """Wire one plate's Peltiers in reverse."""
    hand.plates.reversed[BAD] = True


def freeze(hand: Hand) -> None:
    """Let one plate's thermistor repeat its last reading."""
    hand.thermistors[BAD].fault = "frozen"


@pytest.mark.parametrize("seconds", [90.0, pytest.param(REPEATED_S, marks=pytest.mark.hardening)])
@pytest.mark.parametrize("fault", [reverse, freeze])
def test_a_bad_plate_gets_two_drives_and_its_tests_however_often_it_is_cleared(
    fault: Callable[[Hand], None], seconds: float
) -> None:
    hand = Hand(TURNS_C)
    hand.run(6.0)
    assert hand.faults == []
    fault(hand)
    hand.driven_s[:] = 0.0
    hand.run(seconds)

    pulses_s = 2.0 * 0.5 * TEST_DRIVE * (seconds / TEST_EVERY_S + 1.0)
    assert hand.driven_s[BAD] <= FIRST_TWO_S + pulses_s
    assert max(hand.plate_peak_c[BAD], hand.skin_peak_c[BAD]) <= PLATE_PEAK_C
    assert len(hand.faults) == 2
    assert [each.needs_test for each in hand.faults] == [False, True]
    assert {each.plate for each in hand.faults} == {BAD}


@pytest.mark.parametrize("fault", [reverse, freeze])
def test_other_fingers_work_beside_a_faulty_plate_which_works_again_once_repaired(
    fault: Callable[[Hand], None],
) -> None:
    hand = Hand(TURNS_C)
    hand.run(6.0)
    fault(hand)
    hand.run(40.0)
    assert len(hand.faults) == 2
    start_c = float(hand.plates.plate_c[BAD])
    hand.driven_s[:] = 0.0
    hand.reset_peaks()
    hand.run(2.0 * TEST_EVERY_S)
    assert hand.output.limited[BAD] & Limit.PLATE_TEST
    assert not hand.output.limited[SOUND] & Limit.PLATE_TEST
    assert hand.driven_s[SOUND] > 3.0
    assert 0.0 < hand.driven_s[BAD] <= 3.0 * 2.0 * 0.5 * TEST_DRIVE + 1e-6
    assert hand.plate_peak_c[BAD] <= max(start_c, 34.0) + RISE_K
    hand.plates.reversed[BAD] = False
    hand.thermistors[BAD].fault = None
    hand.run(TEST_EVERY_S + 5.0)
    assert hand.gate.undriven == [False] * N
    latched = len(hand.faults)  # a thermistor's leap as it is mended is a fault of its own
    hand.driven_s[:] = 0.0
    hand.run(20.0)
    assert len(hand.faults) == latched
    assert hand.driven_s[BAD] > 1.0


@pytest.mark.parametrize("noise_k", [0.01, 0.1])
def test_sound_plates_pass_their_test_at_once_from_any_state(noise_k: float) -> None:
    hand = Hand(TURNS_C, noise_k)
    hand.run(6.0)
    for finger in FINGERS:  # as when all modules' cooling water was lost twice, and has come back
        for _ in range(2):
            hand.gate.clear_fault()
            hand.gate.trip(Fault(FaultCode.COOLING_LOST, finger))
    assert hand.gate.undriven == [True] * N
    hand.run(CLEARED_AFTER_S + 10.0)
    assert hand.gate.undriven == [False] * N
    hand.run(20.0)
    assert len(hand.faults) == 1
