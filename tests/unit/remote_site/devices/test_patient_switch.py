"""The driver of the patient's stop switch at its emulator: anything but fresh closed reports shows."""

import math
from collections.abc import Callable

import pytest

from common.buses.serial_messages import SLIDER_FULL
from common.faults.fault import FaultCode
from common.limits import SWITCH_HOLD_S, SWITCH_LOST_S, SWITCH_SILENCE_S
from remote_site.devices.patient_switch import PatientSwitch as Driver
from remote_site.safety.patient_stop import SwitchReading, patient_stop
from sim_sensors.devices.breakable_parts import Babble
from sim_sensors.devices.patient_switch import GONE, RATE_HZ
from sim_sensors.devices.patient_switch import PatientSwitch as Emulator
from teletaction.testbed.memory_lines import MemoryLine
from teletaction.testbed.memory_wiring import MemoryWiring

DT_S = 0.004
REPORT_S = 1.0 / RATE_HZ


class Line:
    """Emulator and driver at the two ends of a line, on a virtual clock."""

    def __init__(self) -> None:
        self.t_s = 50.0
        wiring = MemoryWiring(lambda: self.t_s)
        self.emulator = Emulator(self.t_s)
        wiring.line(self.emulator, "switch", "patient_switch")
        self.server: MemoryLine = wiring.lines["switch"]
        self.driver = Driver("switch", wiring)

    def step(self) -> SwitchReading:
        self.t_s += DT_S
        self.server.pump(self.t_s)
        self.driver.read(self.t_s)
        return self.driver.reading(self.t_s)

    def run(self, seconds: float) -> list[SwitchReading]:
        return [self.step() for _ in range(round(seconds / DT_S))]

    def until(self, reached: Callable[[SwitchReading], object], patience_s: float = 5.0) -> float:
        """Let time pass until a reading is as wanted; returns how long it took, s."""
        begun_s = self.t_s
        while not reached(self.step()):
            assert self.t_s - begun_s < patience_s
        return self.t_s - begun_s


def stops(reading: SwitchReading) -> bool:
    return patient_stop(reading)[0]


def code(reading: SwitchReading) -> FaultCode | None:
    fault = patient_stop(reading)[1]
    return fault.code if fault else None


@pytest.fixture
def line() -> Line:
    line = Line()
    line.until(lambda reading: not stops(reading))
    return line


def test_before_its_first_report_the_switch_stops_without_a_fault() -> None:
    line = Line()
    line.server.silent = True
    assert all(patient_stop(reading) == (True, None) for reading in line.run(2.0 * SWITCH_LOST_S))
    line.server.silent = False
    line.until(lambda reading: not stops(reading))


def test_reports_of_one_measurement_are_no_fresh_ones(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    """A module whose measurement hangs would hide a press, although its frames count on."""
    hung_s = line.t_s
    monkeypatch.setattr(Emulator, "_time_us", lambda emulator, now_s: round(1e6 * hung_s))
    assert line.until(lambda reading: code(reading) is FaultCode.PATIENT_SWITCH_FAILED) < 3.0 * REPORT_S


def test_at_rest_nothing_is_wrong(line: Line) -> None:
    readings = line.run(10.0)
    assert {reading[::2] for reading in readings} == {(True, "")}
    assert max(reading.age_s for reading in readings) < REPORT_S
    assert not line.driver.pressed
    assert line.driver.line.name == "patient_switch"


def test_a_press_is_reported_within_a_report_and_is_held(line: Line) -> None:
    line.emulator.press(line.t_s)
    assert line.until(lambda reading: code(reading) is FaultCode.PATIENT_STOP) <= REPORT_S + DT_S
    assert line.driver.pressed
    assert all(stops(reading) for reading in line.run(SWITCH_HOLD_S - 3.0 * REPORT_S))
    assert line.until(lambda reading: not stops(reading)) < 5.0 * REPORT_S
    line.emulator.pressed = True
    assert all(not reading.closed for reading in line.run(10.0)[5:])


def test_a_press_within_a_silence_is_not_lost(line: Line) -> None:
    line.server.silent = True
    line.run(0.1)
    line.emulator.press(line.t_s)
    line.run(SWITCH_LOST_S - 0.15)
    line.server.silent = False
    line.until(lambda reading: code(reading) is FaultCode.PATIENT_STOP, patience_s=2.0 * REPORT_S)


def test_a_press_that_is_over_when_a_late_site_reads_counts(line: Line) -> None:
    line.emulator.press(line.t_s)
    until_s = line.t_s + SWITCH_HOLD_S + 3.0 * REPORT_S
    while line.t_s < until_s:
        line.t_s += DT_S
        line.server.pump(line.t_s)
    assert code(line.step()) is FaultCode.PATIENT_STOP
    line.until(lambda reading: not stops(reading))


def test_silence_stops_then_is_a_fault(line: Line) -> None:
    line.server.silent = True
    assert line.until(stops) <= SWITCH_SILENCE_S + DT_S
    assert code(line.driver.reading(line.t_s)) is None
    line.until(code)
    assert line.driver.reading(line.t_s).age_s == pytest.approx(SWITCH_LOST_S, abs=2.0 * DT_S)
    line.server.silent = False
    assert line.until(lambda reading: not stops(reading)) <= 2.0 * REPORT_S


def test_a_pulled_cable_is_a_fault_until_it_is_back(line: Line) -> None:
    line.server.unplug()
    assert line.step().wrong == "is unplugged"
    assert all(code(reading) is FaultCode.PATIENT_SWITCH_FAILED for reading in line.run(1.0))
    line.server.plug()
    line.until(lambda reading: not stops(reading))
    assert {reading.wrong for reading in line.run(1.0)} == {""}


def test_one_damaged_frame_counts(line: Line) -> None:
    line.server.unread += b"\5\1\2\3\4\0"
    assert line.step().wrong == "sends wrong frames"
    assert {reading.wrong for reading in line.run(1.0)} == {""}


@pytest.mark.parametrize("fault", ["hung", "babble"])
def test_a_counter_that_stands_and_rubbish_between_frames_count_at_once(line: Line, fault: str) -> None:
    if fault == "hung":
        line.emulator.hung = True
    else:
        line.server.babble = Babble(921_600)
    assert line.until(lambda reading: reading.wrong == "sends wrong frames") <= REPORT_S + DT_S


def test_a_new_connection_may_begin_within_a_frame(line: Line) -> None:
    line.server.unplug()
    line.step()
    line.server.plug()
    line.until(lambda _: line.driver.line.connected)
    line.server.unread[:0] = b"\7\1\0"
    assert {reading.wrong for reading in line.run(1.0)} == {""}
    assert not stops(line.step())


def test_a_device_without_a_slider_reports_no_pain(line: Line) -> None:
    line.run(1.0)
    assert line.driver.pain_reading(line.t_s) is None


def test_the_slider_is_read_and_an_old_answer_is_unknown(line: Line) -> None:
    line.emulator.pain = 0.42
    line.run(0.1)
    assert line.driver.pain_reading(line.t_s) == pytest.approx(4.2)
    line.server.silent = True
    line.run(SWITCH_LOST_S + 0.1)
    reading = line.driver.pain_reading(line.t_s)
    assert reading is not None
    assert reading != reading, "NaN"


def test_pain_is_no_press(line: Line) -> None:
    line.emulator.pain = 1.0
    assert not any(stops(reading) for reading in line.run(1.0))


def test_a_slider_that_is_no_longer_reported_is_unknown_and_no_press(line: Line) -> None:
    line.emulator.pain = 0.42
    line.run(0.1)
    line.emulator.slider = GONE
    assert not any(stops(reading) for reading in line.run(0.1))
    reading = line.driver.pain_reading(line.t_s)
    assert reading is not None
    assert math.isnan(reading)
    line.emulator.slider = None
    line.run(0.1)
    assert line.driver.pain_reading(line.t_s) == pytest.approx(4.2)


def test_a_slider_beyond_its_end_counts_as_a_press(line: Line) -> None:
    line.emulator.slider = SLIDER_FULL + 1
    assert line.until(lambda reading: reading.wrong == "sends wrong frames") <= REPORT_S + DT_S
