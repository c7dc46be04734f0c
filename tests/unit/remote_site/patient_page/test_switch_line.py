"""The tablet's line, read by the remote site's own driver."""

import time
from collections.abc import Callable, Iterator

import pytest

from common.buses.serial_messages import PatientSwitchState
from common.limits import SWITCH_LOST_S, SWITCH_SILENCE_S
from remote_site.devices.patient_switch import PatientSwitch
from remote_site.patient_page.switch_line import RATE_HZ, SwitchLine
from tests.waiting import wait_until


class Site:
    """The line with the driver at its other end."""

    def __init__(self) -> None:
        self.line = SwitchLine(0)
        self.driver = PatientSwitch(f"socket://127.0.0.1:{self.line.port}")
        self.report: PatientSwitchState | None = PatientSwitchState(0, True, 300)

    def turn(self) -> None:
        if self.report is not None:
            self.report.device_time_us += round(1e6 / RATE_HZ)
        self.line.step(time.monotonic(), self.report)
        self.driver.read(time.monotonic())

    def until(self, reached: Callable[[], object]) -> None:
        def turned() -> object:
            self.turn()
            return reached()

        wait_until(turned)

    def heard(self) -> bool:
        return self.driver.reading(time.monotonic()).age_s < SWITCH_SILENCE_S


@pytest.fixture
def site() -> Iterator[Site]:
    site = Site()
    yield site
    site.driver.line.close()
    site.line.close()


def test_the_driver_finds_it_and_reads_contact_and_slider(site: Site) -> None:
    assert not site.line.connected
    site.until(site.heard)
    assert site.line.connected
    assert not site.driver.pressed
    assert site.driver.pain == 3.0
    site.report = PatientSwitchState(0, False, 900)
    site.until(lambda: site.driver.pressed)
    assert site.driver.reading(time.monotonic()).wrong == ""


@pytest.mark.long
def test_its_silence_is_the_silence_of_the_switch(site: Site) -> None:
    site.until(site.heard)
    site.report = None
    site.until(lambda: site.driver.reading(time.monotonic()).age_s > SWITCH_LOST_S)
    assert site.line.connected


def test_a_site_that_goes_and_comes_back_is_served_again(site: Site) -> None:
    site.until(site.heard)
    site.driver.line.close()
    wait_until(lambda: site.line.step(time.monotonic(), site.report) or not site.line.connected)
    site.driver = PatientSwitch(f"socket://127.0.0.1:{site.line.port}")
    site.until(site.heard)


def test_reports_come_at_their_rate_however_often_it_steps(site: Site) -> None:
    site.until(site.heard)
    sent: list[float] = []
    site.line._send = lambda message_id, payload: sent.append(now_s)  # type: ignore[method-assign]
    begun_s = now_s = time.monotonic() + 1.0
    while now_s < begun_s + 1.0:
        now_s += 0.0037
        site.line.step(now_s, site.report)
    assert len(sent) == pytest.approx(RATE_HZ, abs=1)


def test_a_port_in_use_is_named(site: Site) -> None:
    with pytest.raises(OSError, match=rf"{site.line.port} \(switch\).*switch_port"):
        SwitchLine(site.line.port)
