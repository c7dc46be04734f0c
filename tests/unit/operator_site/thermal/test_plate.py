"""From the scene's flux to a plate's set-point, its temperature loop, and its sensor."""

import math

import numpy as np
import pytest

from common.buses.thermometry import ntc_c
from common.faults.fault import FaultCode
from common.limits import COMFORT, WIDE
from operator_site.devices.ntc import PlateSensor
from operator_site.safety.limit_flags import Limit
from operator_site.thermal.plates import PLATE_CONTACT_M2K_W, PlateController, PlateSetpoint
from operator_site.thermal.scene_skin import SkinState
from operator_site.thermal.skin_model import SkinModel
from operator_site.thermal.tissue import LAYERS


def state(surface_c: float, flux: float) -> SkinState:
    return SkinState(*([value] * 5 for value in (33.0, 33.0, 34.0, surface_c, flux)))


def counts(temperature_c: float) -> int:
    return min(range(1, 4095), key=lambda n: abs(ntc_c(n) - temperature_c))


def test_flux_is_matched_through_the_plates_own_contact():
    """On the commanded plate an equal skin takes the scene's flux, so it feels the scene's temperature."""
    display = PlateSetpoint(COMFORT, [33.0] * 5)
    display.aim(state(30.0, -3000.0), [True] * 5, {})
    for _ in range(400):
        set_c = display.step(0.01)
    assert set_c == pytest.approx([30.0 - 3000.0 * PLATE_CONTACT_M2K_W] * 5)
    half = LAYERS[0].thickness_m / SkinModel(4, 1, 1, 6).epidermis / 2.0 / LAYERS[0].conductivity_w_mk
    first_cell = 30.0 + 3000.0 * half
    assert (set_c[0] - first_cell) / (PLATE_CONTACT_M2K_W + half) == pytest.approx(-3000.0)


def test_free_finger_is_shown_its_own_temperature():
    display = PlateSetpoint(COMFORT, [31.0] * 5)
    display.aim(state(33.0, -80.0), [False, True, False, False, False], {})
    for _ in range(400):
        set_c = display.step(0.01)
    assert set_c[0] == pytest.approx(33.0)
    assert set_c[1] == pytest.approx(33.0 - 80.0 * PLATE_CONTACT_M2K_W)
    assert display.limited == [0] * 5


@pytest.mark.parametrize(
    ("surface_c", "flux_w_m2", "load_w_m2"),
    [
        (30.0, -3000.0, -3000.0),
        (30.0, -30_000.0, (COMFORT.low_c - 30.0) / PLATE_CONTACT_M2K_W),
        (30.0, 30_000.0, (COMFORT.high_c - 30.0) / PLATE_CONTACT_M2K_W),
        (15.0, -100.0, 0.0),
    ],
)
def test_the_expected_load_is_that_of_a_plate_within_its_range(surface_c, flux_w_m2, load_w_m2):
    display = PlateSetpoint(COMFORT, [33.0] * 5)
    display.aim(state(surface_c, flux_w_m2), [True] * 5, {})
    assert display.load_w_m2() == pytest.approx([load_w_m2] * 5)


@pytest.mark.parametrize("profile", [COMFORT, WIDE])
def test_set_point_keeps_range_and_rate_and_reports_limits(profile):
    display = PlateSetpoint(profile, [33.0] * 5)
    for goal, rate, bound in ((-20.0, -2.5, profile.low_c), (80.0, 4.0, profile.high_c)):
        display.aim(state(goal, 0.0), [True] * 5, {})
        before = display.set_c[0]
        after = display.step(0.002)[0]
        assert after - before == pytest.approx(rate * 0.002)
        assert display.limited == [Limit.PLATE_RANGE | Limit.PLATE_RATE] * 5
        for _ in range(20_000):
            after = display.step(0.002)[0]
        assert after == bound
        assert display.limited == [Limit.PLATE_RANGE] * 5


def test_display_restarts_from_the_plate():
    display = PlateSetpoint(COMFORT, [33.0] * 5)
    display.restart(0, 25.0)
    display.restart(1, math.nan)
    display.restart(2, 5.0)
    assert display.set_c[:3] == [25.0, 33.0, 20.0]


@pytest.mark.parametrize(("heating", "cooling", "lag"), [(4.0, 2.5, 0.15), (5.5, 2.7, 0.06), (3.5, 2.5, 0.3)])
def test_loop_follows_ramps_and_holds(heating, cooling, lag):
    """Also where the plate is stronger, weaker or its sensor slower than the loop believes."""
    loop, plate, reading, set_c, errors = PlateController(), 30.0, 30.0, 30.0, []
    for tick in range(2500):
        t_s = tick * 0.01
        goal = 34.0 if t_s < 5.0 else 28.0 if t_s < 12.0 else 31.0
        set_c += min(0.036, max(-0.015, goal - set_c))
        drive = loop.step(t_s, set_c, round(reading * 45.0) / 45.0)
        assert -1.0 <= drive <= 1.0
        plate += 0.01 * (drive * (heating if drive > 0.0 else cooling) - 0.03 * (plate - 30.0))
        reading += (plate - reading) * 0.01 / lag
        errors.append(abs(plate - set_c))
    assert max(errors) < 0.6
    assert max(errors[-300:]) < 0.06


def test_heat_taken_by_the_finger_is_fed_forward():
    """Cold metal draws up to some kW/m2 from a finger, and so from nothing into the plate: known, it costs no error."""

    def largest_error(share: float) -> float:
        loop, plate, errors = PlateController(), 30.0, []
        for tick in range(400):
            flux = -3000.0 * math.exp(-tick * 0.01) if tick >= 100 else 0.0
            drive = loop.step(tick * 0.01, 30.0, plate, share * flux)
            push = 3.25 * drive + 0.75 * drive * drive
            plate += 0.01 * (push - flux / 2000.0)
            errors.append(abs(plate - 30.0))
        return max(errors)

    assert largest_error(share=1.0) < 0.05
    assert largest_error(share=0.0) > 3.0 * largest_error(share=0.7)  # known but for a third: a third of the error


def test_loop_does_not_wind_up_on_a_plate_that_cannot():
    loop, plate, set_c, drive, behind = PlateController(), 30.0, 30.0, 0.0, []
    for tick in range(3000):
        set_c = max(20.0, set_c - 0.025) if tick < 2000 else min(30.0, set_c + 0.035)
        drive = loop.step(tick * 0.01, set_c, plate)
        plate = max(24.0, plate + 0.01 * drive * (4.0 if drive > 0.0 else 2.5))
        behind.append(abs(plate - set_c))
        if tick == 1999:
            assert drive == -1.0
    assert max(behind[2150:]) < 1.1  # it turns at once, although it wanted the impossible for 20 s
    assert behind[-1] < 0.05


def test_loop_without_a_reading_drives_nothing_and_restarts():
    loop = PlateController()
    for tick in range(100):
        loop.step(tick * 0.01, 38.0, 30.0)
    assert loop.step(1.0, 38.0, math.nan) == 0.0
    assert loop.step(1.01, math.nan, 30.0) == 0.0
    assert loop.step(1.02, 30.0, 30.0) == 0.0  # the integral is gone
    assert loop.step(5.0, 30.0, 30.0) == 0.0


SHORT, OPEN = FaultCode.PLATE_THERMISTOR_SHORT, FaultCode.PLATE_THERMISTOR_OPEN


def test_sensor_reads_and_refuses():
    sensor = PlateSensor()
    assert sensor.step(0.0, counts(33.0)).plate_c == pytest.approx(33.0, abs=0.02)
    for wrong, fault in ((0, SHORT), (100, SHORT), (3995, OPEN), (4095, OPEN)):
        reading = sensor.step(0.01, wrong)
        assert math.isnan(reading.plate_c)
        assert reading.fault is fault


@pytest.mark.parametrize(("rate", "believed"), [(4.0, True), (7.0, True), (-7.0, True), (9.5, False), (-9.5, False)])
def test_sensor_that_changes_too_fast_is_not_believed(rate, believed):
    sensor = PlateSensor()
    faults = [sensor.step(i * 0.01, counts(33.0 + rate * i * 0.01)).fault for i in range(40)]
    assert (not any(faults)) == believed


@pytest.mark.long
def test_late_readings_in_a_burst_are_no_fault():
    sensor, rate = PlateSensor(), 5.3  # as fast as a strong plate warms
    for i in range(300):
        arrives_s = i * 0.01 if i % 40 > 9 else (i // 40 * 40 + 9) * 0.01  # 90 ms of silence, then all at once
        assert sensor.step(arrives_s, counts(20.0 + rate * i * 0.01)).fault is None


def test_sensor_noise_and_silence_are_no_fault():
    sensor, noise = PlateSensor(), np.random.default_rng(0)
    assert not any(sensor.step(i * 0.01, 1700 + round(noise.normal(0.0, 1.5))).fault for i in range(500))
    assert sensor.step(9.0, 1300).fault is None
    assert sensor.step(1.0, 1700).fault is None
