"""Calibration finds the constants that made-up touches were made with."""

from collections.abc import Sequence

import numpy as np
import pytest

from common.runtime.parallel_map import Map, Progress, kept_processes, unseen
from remote_site.thermal.calibration.calibration_touches import CalibrationReadings, CalibrationTouch
from remote_site.thermal.calibration.population_fit import Population, fit_populations, population_scatter
from remote_site.thermal.calibration.thermal_calibration import calibrate_traces
from studies.second_world.touches import Kind, simulate_touches
from tests.unit.remote_site.made_touches import (
    AMBIENT_C,
    MATERIALS,
    PLATE_J_M2K,
    SENSOR,
    Force,
    MadeMaterial,
    MadeSensor,
    made_touches,
    pressed,
)

pytestmark = pytest.mark.long

FORCES = tuple(pressed(force_n) for force_n in (0.6, 1.2, 3.0))
"""Pressed differently, because equal forces do not show how the contact follows the force."""
EACH = 6
"""Touches of each material at each force."""


def fit(
    materials: dict[str, MadeMaterial],
    sensor: MadeSensor = SENSOR,
    object_sd_k: float = 0.03,
    each: int = EACH,
    forces: Sequence[Force] = FORCES,
    mapped: Map = map,
    progress: Progress = unseen,
) -> tuple[Population, list[float]]:
    """The fit, and the true object temperatures above ambient."""
    touches, objects_k = [], []
    for number, (name, material) in enumerate(materials.items()):
        for seed, force in enumerate(forces):
            made = made_touches(name, each, 31 * number + seed, 4.0, sensor=sensor, material=material, force=force)
            for touch in made:
                after = np.array(touch.after())
                known = object_sd_k < 1.0
                touches.append(
                    CalibrationTouch(
                        number,
                        after[:, 1],
                        after[:, 2],
                        touch.start_c,
                        0.0,
                        AMBIENT_C,
                        touch.object_c if known else AMBIENT_C,
                        object_sd_k,
                    )
                )
                objects_k.append(touch.object_c - AMBIENT_C)
    leak_per_s = sensor.leak_w_m2k / PLATE_J_M2K
    readings = CalibrationReadings.of(touches)
    return fit_populations(readings, len(materials), leak_per_s * 1.2, mapped, progress), objects_k


@pytest.fixture(scope="module")
def found() -> Population:
    return fit(MATERIALS)[0]


def test_the_fit_is_the_same_for_any_number_of_processes() -> None:
    few = dict(list(MATERIALS.items())[:2])
    shares: list[float] = []
    with kept_processes(2) as mapped:
        (shared, objects_k), (alone, _) = fit(few, each=2, mapped=mapped), fit(few, each=2, progress=shares.append)
    for name in Population.__dataclass_fields__:
        assert np.array_equal(getattr(shared, name), getattr(alone, name)), name
    assert len(objects_k) == len(shared.object_k)
    assert shares == sorted(shares)
    assert 0.0 == shares[0] < shares[-1] < 1.0


def test_the_sensors_constants_and_that_the_model_fits(found: Population) -> None:
    assert found.sensor.leak_per_s == pytest.approx(SENSOR.leak_w_m2k / PLATE_J_M2K, rel=0.15)
    assert np.exp(found.ln_lag) == pytest.approx(SENSOR.lag_s, rel=0.05)
    assert found.sensor.half_force_n == pytest.approx(SENSOR.half_force_n, rel=0.25)
    assert found.back_share == pytest.approx(SENSOR.back_share, abs=0.15)
    quantised = np.hypot(SENSOR.noise_k, 100.0 / 4096 / np.sqrt(12.0))
    assert quantised < found.noise_k < 1.4 * quantised
    assert found.misfit == pytest.approx(1.0, abs=0.3)


def test_the_materials(found: Population) -> None:
    for number, material in enumerate(MATERIALS.values()):
        wanted = np.log([material.effusivity / PLATE_J_M2K, material.conductance_w_m2k / PLATE_J_M2K])
        # the mean of 18 draws is off by a quarter of their scatter; the rest is what the readings leave
        assert found.mean[number] == pytest.approx(wanted, abs=0.1)
        assert np.isinf(found.slab_s[number])
        assert (np.linalg.eigvalsh(found.covariance[number]) > 0.0).all()
        scatter = np.sqrt(np.diag(found.covariance[number]))
        assert material.piece_sd / 2.5 < scatter[0] < 2.5 * material.piece_sd
        assert material.contact_sd / 2.0 < scatter[1] < 2.0 * material.contact_sd


def test_another_sensor_gives_other_constants() -> None:
    sensor = MadeSensor(leak_w_m2k=40.0, back_share=0.6, lag_s=0.15, half_force_n=0.6, noise_k=0.05)
    found = fit(MATERIALS, sensor, each=3)[0]
    assert found.sensor.leak_per_s == pytest.approx(40.0 / PLATE_J_M2K, rel=0.3)
    assert np.exp(found.ln_lag) == pytest.approx(0.15, rel=0.1)
    assert found.sensor.half_force_n == pytest.approx(0.6, rel=0.3)
    assert 0.0505 < found.noise_k < 1.4 * 0.0505


def test_a_soft_sensor_conducts_like_a_power_of_the_force() -> None:
    """Slowly pressed to several newtons, as fabric is: its readings hardly move at first, then ever faster."""
    sensor = MadeSensor(lag_s=0.6, half_force_n=5.0, force_power=2.0)
    found = fit(MATERIALS, sensor, forces=tuple(pressed(force_n, ramp_s=1.5) for force_n in (3.0, 4.5)))[0]
    assert found.sensor.force_power == pytest.approx(2.0, rel=0.15)
    assert found.sensor.half_force_n == pytest.approx(5.0, rel=0.2)
    assert (found.misfit < 1.5).all()
    assert found.noise_k < 2.0 * np.hypot(sensor.noise_k, 0.007)


def test_thin_pieces_are_recognised() -> None:
    materials = {**MATERIALS, "metal": MadeMaterial(14000.0, 2200.0, slab_s=1.0)}
    found = fit(materials, each=4)[0]
    assert np.isfinite(found.slab_s[0])
    assert np.isinf(found.slab_s[2])
    # once the slab is warm through, which is soon, its readings show its heat capacity e sqrt(slab_s) and no more
    capacity = np.exp(found.mean[0, 0]) * PLATE_J_M2K * np.sqrt(found.slab_s[0])
    assert capacity == pytest.approx(14000.0, rel=0.1)


def test_unmeasured_temperatures_are_found() -> None:
    """Without labels, the mean of a metal's objects counts as ambient, which changes its effusivity too."""
    found, objects_k = fit(MATERIALS, object_sd_k=3.0, each=4)
    off = found.object_k - np.array(objects_k)
    metal = off[: 3 * 4]
    assert np.std(metal) < 0.1
    assert metal.mean() == pytest.approx(-np.mean(objects_k[: 3 * 4]), abs=0.1)
    assert np.sqrt(np.mean(off**2)) < 0.35
    shares = np.exp(found.mean[:, 0]) * PLATE_J_M2K / [material.effusivity for material in MATERIALS.values()]
    assert 0.5 < shares[0] < 1.5
    assert shares[1:] == pytest.approx(1.0, abs=0.35)


@pytest.mark.parametrize("touches", [2, 10, 25])
def test_touches_whose_effusivity_and_conductance_go_together_have_a_covariance(touches: int) -> None:
    along = np.linspace(-1.0, 1.0, touches)[:, np.newaxis] * np.array([2.0, -2.0])
    found = population_scatter(along, np.tile(1e-6 * np.eye(2), (touches, 1, 1)))
    assert np.linalg.eigvalsh(found)[0] > 0.0
    np.testing.assert_array_equal(found, found.T)


@pytest.mark.long
def test_a_sensor_of_another_physics_without_labels_keeps_one_lag() -> None:
    """From one beginning alone, every touch gets another lag: its scatter is 42 % and the noise half as large again."""
    kind = Kind.draw(61)
    touches = [
        (name, hand.fingers[0].trace, None)
        for name in ("aluminium", "ceramic_tile", "pvc", "pine")
        for seed, unit in enumerate(kind.units)
        for hand in simulate_touches(Kind(kind.sensor, (unit,)), name, 10 + seed, range(1), seconds=6.3)
    ]
    table = calibrate_traces(touches).table
    assert table.ln_lag_sd < 0.1
    assert table.noise_k < 0.03
