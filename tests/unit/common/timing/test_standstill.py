"""A standstill of the host's clock is found by the clocks of its devices, and nothing else is taken for one."""

import math
import time

import pytest

from common.timing.standstill import BEHIND_S, BELIEVED_S, DRIFT, HostClock, Witness, _ahead_ns, since_boot_ns
from common.timing.timeouts import STANDSTILL_S

REPORT_S = 0.010
WAITING = 20
WRAPS_US = 1 << 32


class Device:
    """Reports every 10 ms; `step` lets true time pass, with less of it on the host's clock.

    Of reports that nobody reads a line keeps WAITING: the first, the newest comes with them.
    """

    def __init__(self, device_us: int = 0) -> None:
        self.witness = Witness()
        self.host_s = self.true_s = 0.0
        self._from_us = device_us
        self.step()

    def step(self, true_s: float = REPORT_S, host_s: float = REPORT_S, pace: float = 1.0) -> float:
        self.true_s += true_s * pace
        self.host_s += host_s
        waiting = range(1, min(WAITING, round(true_s / REPORT_S)))
        before_s = self.true_s - true_s * pace
        reported_s = [before_s + number * REPORT_S * pace for number in waiting] + [self.true_s]
        found_s = self.witness.report(self.host_s, [self._us(each_s) for each_s in reported_s])
        self.host_s += found_s
        return found_s

    def _us(self, time_s: float) -> int:
        return (self._from_us + round(time_s * 1e6)) % WRAPS_US

    def run(self, reports: int, pace: float = 1.0) -> list[float]:
        return [found_s for _ in range(reports) if (found_s := self.step(pace=pace))]


@pytest.mark.parametrize("stood_s", [0.08, 0.15, 0.3, 1.0, 3.0, 30.0, 2000.0])
@pytest.mark.parametrize("device_us", [0, WRAPS_US - 500_000])
def test_each_standstill_is_found_in_full_across_a_wrap_of_the_devices_clock(stood_s: float, device_us: int) -> None:
    device = Device(device_us)
    for _ in range(3):
        assert device.run(20) == []
        assert device.step(stood_s) == pytest.approx(stood_s - REPORT_S, abs=2e-3)
    assert device.run(1000) == []
    assert device.host_s == pytest.approx(device.true_s, abs=0.01)


@pytest.mark.parametrize("pace", [1.0 - DRIFT, 1.0, 1.0 + DRIFT])
def test_drift_is_no_standstill_and_hides_none(pace: float) -> None:
    device = Device()
    assert device.run(5000, pace) == []
    assert device.step(0.2, pace=pace) == pytest.approx(0.19, abs=0.02)


@pytest.mark.parametrize("late_s", [0.03, 0.5, 3.0, 60.0])
def test_a_late_line_is_no_standstill_in_any_order_of_reports(late_s: float) -> None:
    """Old reports come first, a piece in each tick, and the line has caught up at the end."""
    device = Device()
    device.run(100)
    device.host_s += late_s
    found = [device.step(late_s / 20.0, 0.002) for _ in range(20)]
    assert found == [0.0] * 20
    assert device.step(0.2) > STANDSTILL_S


@pytest.mark.parametrize("pace", [1.0 - DRIFT, 0.9999, 1.0])
@pytest.mark.parametrize(("late_s", "for_s"), [(0.2, 5.0), (0.2, 60.0), (0.9, 10.0)])
def test_a_line_that_is_late_for_seconds_and_catches_up_is_no_standstill(
    late_s: float, for_s: float, pace: float
) -> None:
    device = Device()
    assert device.run(500, pace) == []
    device.true_s -= late_s
    assert device.run(round(for_s / REPORT_S), pace) == []
    device.true_s += late_s
    assert device.run(500, pace) == []
    error_s = (
        0.005 if pace > 1.0 - DRIFT else 0.1
    )  # at the end of DRIFT the pace is measured again after the line was late
    assert device.step(0.3, pace=pace) == pytest.approx(0.29, abs=error_s)


@pytest.mark.parametrize("held_back", [0.9, 0.8, 0.5])
def test_a_device_that_is_held_back_and_catches_up_is_no_standstill(held_back: float) -> None:
    """As a simulated one on a machine that is busy."""
    device = Device()
    assert device.run(500) == []
    assert device.run(150, held_back) == []
    assert device.run(150, 2.0 - held_back) == []
    assert device.step(0.3) == pytest.approx(0.29, abs=0.03)


@pytest.mark.parametrize("leap_s", [0.06, 0.09, 0.5])
def test_a_device_whose_clock_leaps_is_no_standstill(leap_s: float) -> None:
    """As a simulated one on a machine that is full: it is late from the beginning, and gives up what it has missed."""
    device = Device()
    device.run(100)
    device.true_s += leap_s
    assert device.step() == 0.0
    assert device.run(100) == []
    assert device.step(0.3) == pytest.approx(0.29, abs=2e-3)


def test_a_node_whose_frames_come_in_a_heap_has_seen_a_standstill() -> None:
    witness = Witness()
    assert [witness.frames(1.0 + 0.002 * n, n) for n in range(100)] == [0.0] * 100
    assert witness.frames(1.2, 100 + 150) == pytest.approx(0.3, abs=5e-3)


def test_reports_from_before_the_start_of_a_site_are_no_standstill() -> None:
    """It is read in pieces: 0.1 s of frames, or 4096 bytes of a serial module, in each tick."""
    node, module = Witness(), Witness()
    for tick in range(10):
        host_s, drained = 1.0 + 0.002 * tick, tick == 9
        assert node.frames(host_s, 50 * (tick + 1), drained=drained) == 0.0
        reports_us = [5000 * (40 * tick + n) for n in range(40)]
        assert module.report(host_s, reports_us, drained=drained) == 0.0
    assert node.frames(1.022, 500 + 150) == pytest.approx(0.298, abs=5e-3)
    assert module.report(1.022, [5000 * n for n in range(400, 460)]) == pytest.approx(0.298, abs=5e-3)


def test_reading_a_backlog_is_no_standstill() -> None:
    """A full machine gives it ten ticks a second, each reads 0.1 s of frames, and 1.4 s wait for half a minute."""
    node = Witness()
    assert [node.frames(0.002 * n, n) for n in range(1000)] == [0.0] * 1000
    count, host_s = 1000, 3.4
    for _ in range(300):
        host_s += 0.1
        count += 50
        assert node.frames(host_s, count, drained=False) == 0.0
    for more in (*[50] * 14, 28):
        host_s += 0.004
        count += more
        assert node.frames(host_s, count, drained=more < 50) == 0.0
    assert node.frames(host_s + 0.002, count + 150) == pytest.approx(0.3, abs=0.03)


def test_a_restarted_device_is_trusted_again_only_after_a_while() -> None:
    device = Device()
    device.run(100)
    device.true_s -= BEHIND_S + 0.5
    device.run(10)
    device.true_s += BEHIND_S + 0.5
    assert device.run(900) == []
    device.true_s = 0.0
    assert device.run(round(BELIEVED_S / REPORT_S) + 2) == []
    assert device.step(0.3) == pytest.approx(0.29, abs=2e-3)


def test_a_host_clock_set_back_is_corrected_and_one_that_ran_during_a_stop_stays() -> None:
    device = Device()
    device.run(100)
    assert device.step(30.0, 30.0) == 0.0
    assert device.step(REPORT_S, -10.0) == pytest.approx(10.0 + REPORT_S, abs=1e-3)


def test_the_clock_is_put_forward_and_counts_it() -> None:
    clock = HostClock(lambda: 5_000_000_000)
    assert clock.now_s() == 5.0
    assert clock.put_forward(0.25) == 250_000_000
    assert (clock.now_ns(), clock.stood_still_s) == (5_250_000_000, 0.25)


def test_a_suspend_is_counted_by_the_clock_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both clocks of the system begin with the same reading; only one continues in a suspend."""
    boottime_ns = time.clock_gettime_ns(time.CLOCK_BOOTTIME)
    read_ns = since_boot_ns()
    assert abs(read_ns() - time.monotonic_ns()) < 100_000_000
    monkeypatch.setattr(time, "clock_gettime_ns", lambda which: boottime_ns + 30_000_000_000)
    assert read_ns() - time.monotonic_ns() > 29_000_000_000
    assert math.isfinite(HostClock().now_s())


def test_two_clocks_are_compared_although_the_processor_is_lost_between_readings() -> None:
    """Each reading takes 1 us, and 4 ms where the process has to wait; the other clock is 50 us ahead."""
    time_ns, readings = 0, 0

    def read() -> int:
        nonlocal time_ns, readings
        readings += 1
        time_ns += 4_000_000 if readings % 5 == 0 else 1_000
        return time_ns

    assert _ahead_ns(read, lambda: read() + 50_000) == pytest.approx(50_000, abs=1_000)
