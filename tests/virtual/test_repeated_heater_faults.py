"""A thermal sensor that faults again and again at a patient: neither time nor clearing gives its heater more drive."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from common.buses.thermometry import ssr_c
from common.fingers import FINGERS
from common.limits import SENSOR_PLATE_C
from common.safety.repeated_fault import TEST_EVERY_S
from common.wire.packets import N
from remote_site.devices.thermal_sensor import ThermometerCheck
from remote_site.safety.heater_limits import TEST_DRIVE
from remote_site.safety.limit_flags import Limit
from remote_site.safety.patient_gate import PatientGate
from remote_site.thermal.heater_control import HeaterControl
from sim_sensors.devices.breakable_parts import Thermistor
from sim_sensors.physics.thermal_touch import LAG_S, SensorSpread, ThermalTouch
from tests.virtual.session import COARSE_TICK_S

pytestmark = pytest.mark.long

BAD, SOUND = FINGERS.index("index"), FINGERS.index("middle")
CLEARED_EVERY_S = 3.0
WATCHED_S = 120.0
FIRST_S = 2.5
"""Full drive before a sensor needs its test, s: a reversed heater moves its plate the wrong way meanwhile."""
PULSES_S = 2.0 * 0.5 * TEST_DRIVE * (WATCHED_S / TEST_EVERY_S + 1.0)
FREE_M = 0.006


class Sensors:
    """Five thermal sensors in air, their heater loops and the gate; a person clears faults every few seconds.

    Attributes:
        driven_s: integral of each heater's drive without its sign, s of full drive.
        hottest_c: of each plate.
        works: sign of each heater's drive; -1 where it is wired in reverse.
    """

    def __init__(self) -> None:
        spread = SensorSpread(np.linspace(*LAG_S, N), np.ones(N))
        self.touch = ThermalTouch(spread, 23.0, np.random.default_rng(0))
        self.thermistors = [Thermistor() for _ in range(N)]
        self.gate = PatientGate()
        self.works = np.ones(N)
        self.time_s = 0.0
        self.driven_s = np.zeros(N)
        self.hottest_c = np.zeros(N)
        self._plausible = [ThermometerCheck() for _ in range(N)]
        self._loops = [HeaterControl() for _ in range(N)]
        self._drive = [0.0] * N
        self._limited = [0] * N

    def in_test(self, finger: int) -> bool:
        """Whether a heater gets no drive but a test pulse."""
        return bool(self._limited[finger] & Limit.HEATER_TEST)

    def loosen(self, contact: float) -> None:
        """Let the bad sensor have this share of its thermal contact from the beginning."""
        contacts = self.touch.contacts
        contacts.lost_per_s[BAD] = 1.0 - contact
        contacts.read(1.0, self.touch.ssr_c, 23.0)
        contacts.lost_per_s[BAD] = math.ulp(0.0)  # it loses no more

    def run(self, seconds: float) -> None:
        """Let time pass in free air."""
        for _ in range(round(seconds / COARSE_TICK_S)):
            self._tick()

    def _tick(self) -> None:
        self.time_s = now_s = self.time_s + COARSE_TICK_S
        self.touch.step(self.works * np.array(self._drive), np.zeros(N))
        read_c, wanted = [], []
        for finger, raw in enumerate(self.touch.ssr_counts().tolist()):
            counts = self.thermistors[finger].read(raw)
            fault = self._plausible[finger].step(now_s, counts, self._drive[finger])
            read_c.append(math.nan if fault else ssr_c(counts))
            wanted.append(self._loops[finger].step(now_s, ssr_c(counts), 23.0, False, fault=fault))
        if round(now_s / COARSE_TICK_S) % round(CLEARED_EVERY_S / COARSE_TICK_S) == 0:
            self.gate.clear_fault()
        output = self.gate.step(
            now_s,
            True,
            0.0,
            wanted_x_m=0.0,
            wanted_y_m=0.0,
            wanted_z_m=[FREE_M] * N,
            measured_x_m=0.0,
            measured_y_m=0.0,
            measured_z_m=[FREE_M] * N,
            force_n=[0.0] * N,
            force_age_s=0.0,
            heater_drive=wanted,
            sensor_c=read_c,
            ambient_c=[23.0] * N,
            sensor_age_s=[0.0] * N,
            in_contact=[False] * N,
        )
        self._drive, self._limited = output.heater_drive, output.limited
        self.driven_s += COARSE_TICK_S * np.abs(self._drive)
        np.maximum(self.hottest_c, self.touch.plate_c, out=self.hottest_c)


def freeze(sensors: Sensors) -> None:
    """Let one sensor repeat its last reading."""
    sensors.thermistors[BAD].fault = "frozen"


def reverse(sensors: Sensors) -> None:
    """Wire one heater in reverse."""
    sensors.works[BAD] = -1.0


@pytest.mark.parametrize("after_s", [0.5, 1.7], ids=["heated fully", "nearly warm"])
@pytest.mark.parametrize("fault", [freeze, reverse])
def test_two_minutes_with_a_bad_sensor_give_its_heater_little_drive(
    fault: Callable[[Sensors], None], after_s: float
) -> None:
    sensors = Sensors()
    sensors.run(after_s)
    fault(sensors)
    sensors.driven_s[:] = 0.0
    sensors.run(WATCHED_S)
    assert sensors.driven_s[BAD] <= FIRST_S + PULSES_S
    assert sensors.hottest_c[BAD] <= SENSOR_PLATE_C
    assert sensors.in_test(BAD)
    assert not sensors.in_test(SOUND)


@pytest.mark.parametrize("contact", [0.4, 0.5])
def test_a_sensor_that_is_loose_before_the_session_does_not_heat_its_plate_beyond_its_limit(contact: float) -> None:
    sensors = Sensors()
    sensors.loosen(contact)
    sensors.run(2.0)
    assert sensors.in_test(BAD)
    sensors.run(WATCHED_S)
    assert sensors.hottest_c[BAD] <= SENSOR_PLATE_C
    assert not sensors.in_test(SOUND)
    assert sensors.touch.plate_c[SOUND] == pytest.approx(33.0, abs=0.5)


@pytest.mark.parametrize("within_s", [10.0, 40.0])
def test_a_sensor_that_loosens_on_a_warm_plate_is_not_heated_further(within_s: float) -> None:
    sensors = Sensors()
    sensors.run(10.0)
    sensors.touch.contacts.lost_per_s[BAD] = 1.0 / within_s
    sensors.run(within_s)
    assert sensors.in_test(BAD)
    sensors.run(WATCHED_S)
    assert sensors.hottest_c[BAD] <= SENSOR_PLATE_C
    assert not sensors.in_test(SOUND)
    assert sensors.touch.plate_c[SOUND] == pytest.approx(33.0, abs=0.5)


@pytest.mark.parametrize("fault", [freeze, reverse])
def test_a_repaired_sensor_is_heated_again_after_its_test(fault: Callable[[Sensors], None]) -> None:
    sensors = Sensors()
    sensors.run(1.0)
    fault(sensors)
    sensors.run(20.0)
    assert sensors.in_test(BAD)
    sensors.works[BAD] = 1.0
    sensors.thermistors[BAD].fault = None
    sensors.run(TEST_EVERY_S + 20.0)
    assert not any(sensors.in_test(finger) for finger in range(N))
    assert sensors.touch.plate_c[BAD] == pytest.approx(33.0, abs=0.5)
