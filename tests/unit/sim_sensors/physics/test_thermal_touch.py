import numpy as np
import pytest
from scipy.special import wofz

from common.scenes.materials import material
from sim_sensors.physics import thermal_touch as tt
from sim_sensors.physics.object_column import object_column
from sim_sensors.physics.thermal_touch import STAGE_S, STEP_S, SensorSpread, ThermalTouch, force_share

AMBIENT_C = 23.0
FORCE = np.array([1.2])
OFF = np.zeros(1)


def sensor(leak=0.0, lag_s=0.3, cells=48):
    spread = SensorSpread(np.array([lag_s]), np.array([leak]))
    return ThermalTouch(spread, AMBIENT_C, np.random.default_rng(0), cells)


def put_on(touch, name, *, conductance=1400.0, thickness_m=None, object_c=AMBIENT_C, cells=48):
    """Press on an object so that the contact itself has `conductance` at FORCE."""
    kind = material(name)
    heat = kind.density_kg_m3 * kind.specific_heat_j_kgk
    column = object_column(kind.conductivity_w_mk, heat, thickness_m, STAGE_S, cells)
    touch.touch(0, column, object_c, conductance / float(force_share(FORCE)[0]))
    touch.settle(0)
    return column


def half_space_response(times_s, effusivity, resistance):
    """Plate on a half space behind a contact resistance, no leak: closed form from its Laplace transform."""
    capacity = tt.PLATE_J_K / tt.AREA_M2
    r1, r2 = np.roots([1.0, 1.0 / (resistance * effusivity), 1.0 / (capacity * resistance)]).astype(complex)
    root = np.sqrt(times_s)
    return ((r1 * wofz(-1j * r2 * root) - r2 * wofz(-1j * r1 * root)) / (r1 - r2)).real


@pytest.mark.parametrize("name", ["aluminium", "ceramic_tile", "pvc", "pine", "pu_foam"])
def test_half_space_agrees_with_closed_form_within_5_mk_of_10_k(name):
    touch = sensor()
    put_on(touch, name)
    touch.plate_c[:] = AMBIENT_C + 10.0
    times = STEP_S * np.arange(1, 801)
    plate = []
    for _ in times:
        touch.step(OFF, FORCE)
        plate.append(touch.plate_c[0])
    expected = AMBIENT_C + 10.0 * half_space_response(times, material(name).effusivity, 1.0 / 1400.0)
    assert np.abs(np.array(plate) - expected).max() < 0.005


def cool_down(cells):
    touch = sensor(leak=1.0, cells=cells)
    put_on(touch, "ceramic_tile", thickness_m=0.01, cells=cells)
    touch.plate_c[:] = AMBIENT_C + 10.0
    for _ in range(400):
        touch.step(OFF, FORCE)
    return touch.plate_c[0]


def test_twice_as_many_cells_change_less_than_3_mk():
    assert abs(cool_down(48) - cool_down(96)) < 0.003


def test_heat_is_conserved_between_plate_and_object():
    touch = sensor()
    column = put_on(touch, "pvc", thickness_m=0.01, object_c=20.0)
    touch.plate_c[:] = 33.0
    capacity = column.cell_m * column.heat_j_m3k * tt.AREA_M2

    def stored():
        return tt.PLATE_J_K * touch.plate_c[0] + float(capacity @ touch.column_c[0])

    before = stored()
    for _ in range(300):
        touch.step(np.array([0.25]), FORCE)
    assert stored() - before == pytest.approx(0.25 * tt.HEATER_W * 3.0, rel=1e-9)


def test_thin_metal_ends_at_the_mixing_temperature():
    touch = sensor()
    column = put_on(touch, "aluminium", thickness_m=0.001, object_c=20.0)
    touch.plate_c[:] = 33.0
    capacity = float(column.cell_m.sum()) * column.heat_j_m3k * tt.AREA_M2
    for _ in range(1500):
        touch.step(OFF, FORCE)
    mixed = (tt.PLATE_J_K * 33.0 + capacity * 20.0) / (tt.PLATE_J_K + capacity)
    assert touch.plate_c[0] == pytest.approx(mixed, abs=1e-3)


def test_steady_state_in_free_air_is_that_of_the_network():
    touch = sensor(leak=1.0)
    peltier, case, drive = tt.PELTIER_W_K, tt.CASE_LEAK_W_K, 0.07
    heat = drive * tt.HEATER_W
    network = np.array(
        [
            [peltier + case + tt.AIR_W_M2K * tt.AREA_M2, -peltier, -case],
            [-peltier, peltier + tt.BACK_AMBIENT_W_K, 0.0],
            [-case, 0.0, case + tt.CASE_AMBIENT_W_K],
        ]
    )
    plate, back, case_c = AMBIENT_C + np.linalg.solve(network, [heat, tt.BACK_HEATING * heat, 0.0])
    touch.plate_c[:], touch.back_c[:], touch.case_c[:], touch.ssr_c[:] = plate, back, case_c, plate
    for _ in range(500):
        touch.step(np.array([drive]), OFF)
    assert touch.plate_c[0] == pytest.approx(plate, abs=1e-6)
    assert touch.back_c[0] == pytest.approx(back, abs=1e-6)
    assert touch.ssr_c[0] == pytest.approx(plate, abs=1e-6)


def test_full_drive_heats_a_free_plate_by_about_5_k_a_second_and_cools_the_back_side():
    touch = sensor(leak=1.0)
    for _ in range(100):
        touch.step(np.array([1.0]), OFF)
    assert 4.8 < touch.plate_c[0] - AMBIENT_C < 5.2
    assert touch.back_c[0] < AMBIENT_C - 0.2


def test_drive_is_limited_and_cooling_warms_the_back_side():
    touch, limit = sensor(leak=1.0), sensor(leak=1.0)
    for _ in range(50):
        touch.step(np.array([-7.0]), OFF)
        limit.step(np.array([-1.0]), OFF)
    assert touch.plate_c[0] == limit.plate_c[0] < AMBIENT_C - 2.0
    assert touch.back_c[0] > AMBIENT_C + 0.4


def test_sudden_strong_contact_does_not_ring():
    touch = sensor()
    put_on(touch, "copper", conductance=1e7, thickness_m=0.05)
    touch.plate_c[:] = 40.0
    plate = [40.0]
    for _ in range(50):
        touch.step(OFF, FORCE)
        plate.append(touch.plate_c[0])
    assert min(plate) > AMBIENT_C
    assert max(np.diff(plate)[3:]) <= 1e-9


def test_resistor_lags_by_its_time_constant():
    touch = sensor(lag_s=0.4)
    plate, ssr = [AMBIENT_C], [AMBIENT_C]
    for step in range(200):
        touch.step(np.array([1.0 if step < 100 else 0.0]), OFF)
        plate.append(touch.plate_c[0])
        ssr.append(touch.ssr_c[0])
    behind = np.array(plate) - np.array(ssr)
    followed = 0.5 * STEP_S * (behind[:-1] + behind[1:]).sum() / 0.4  # integral of (plate - ssr)/lag
    assert ssr[-1] - AMBIENT_C == pytest.approx(followed, abs=1e-3)
    assert behind[100] > 1.0


def test_contact_conductance_rises_with_force_and_saturates():
    force = np.linspace(0.0, 10.0, 200)
    share = force_share(force)
    assert share[0] == 0.0
    assert np.all(np.diff(share) > 0.0)
    assert np.all(np.diff(share, 2) < 0.0)
    assert share[-1] < 1.0
    assert force_share(np.array([0.3]))[0] == pytest.approx(0.5)


@pytest.mark.parametrize(("name", "rms_m", "resistance"), [("aluminium", 0.5e-6, 6.9e-4), ("pvc", 1e-6, 8.7e-4)])
def test_contact_resistance_is_the_one_that_was_decided(name, rms_m, resistance):
    full = tt.full_conductance_w_m2k(material(name).conductivity_w_mk, rms_m)
    assert 1.0 / (full * force_share(FORCE)[0]) == pytest.approx(resistance, rel=0.02)


def test_sliding_brings_fresh_material_below_the_plate():
    resting, sliding = sensor(), sensor()
    for touch, speed in ((resting, 0.0), (sliding, 0.05)):
        put_on(touch, "pvc", thickness_m=0.01)
        touch.plate_c[:] = 33.0
        for _ in range(200):
            touch.step(OFF, FORCE, speed)
    assert sliding.plate_c[0] < resting.plate_c[0] - 0.5


@pytest.mark.long
def test_readings_have_the_noise_that_was_decided_and_do_not_change_by_being_read():
    touch = sensor()
    counts = []
    for _ in range(3000):
        touch.step(OFF, OFF)
        assert touch.ssr_counts()[0] == touch.ssr_counts()[0]
        counts.append(int(touch.ssr_counts()[0]))
    step_k = 0.0150
    expected = np.hypot(tt.NOISE_C, step_k / np.sqrt(12.0))
    assert np.std(counts) * step_k == pytest.approx(expected, rel=0.08)
