"""Elastic tissue with nodules, against Hertz, Hayes, symmetry, and a denser mesh."""

import numpy as np
import pytest

from sim_sensors.tissue.contrast import LARGEST_SHARE, Sphere, taken_share
from sim_sensors.tissue.finite_elements import POISSON, Body, punch_compliance
from sim_sensors.tissue.ground import Ground, force_at
from sim_sensors.tissue.layer import half_space_compliance, layer_share

HAYES = {
    0.3: {0.2: 1.207, 0.4: 1.472, 0.6: 1.784},
    0.45: {0.2: 1.252, 0.4: 1.599, 0.6: 2.031},
    0.5: {0.2: 1.281, 0.4: 1.683, 0.6: 2.211},
}
"""Layer over half space, stiffness, by Poisson's ratio and punch radius / thickness (Hayes et al. 1972)."""
PLACE = np.zeros(1)


@pytest.mark.parametrize(("poisson", "radius"), [(p, a) for p, row in HAYES.items() for a in row])
def test_a_layer_is_as_stiff_as_the_published_solution(poisson: float, radius: float) -> None:
    assert 1.0 / layer_share(radius, 1.0, poisson) == pytest.approx(HAYES[poisson][radius], rel=0.005)


def test_elements_give_the_compliance_of_a_layer() -> None:
    body = Body(cover=0.5, beneath=2.0)
    found = punch_compliance(body, (1.0,), [(0.5, 0.0), (1.0, 0.0)], harmonics=1)[0]
    whole = [half_space_compliance(a, POISSON) * layer_share(a, body.layer, POISSON) for a in (0.5, 1.0)]
    assert found == pytest.approx(np.array(whole), rel=0.03)


def test_a_sphere_of_the_ground_s_stiffness_takes_nothing_away() -> None:
    none = taken_share(Sphere(0.0, 0.0, 10.0, 3.0, 1.0), 40.0, np.array([2.0, 4.0]), np.array([0.0, 3.0]))
    assert none == pytest.approx(np.zeros(2), abs=1e-6)


@pytest.mark.long
@pytest.mark.parametrize(("size_mm", "depth_mm", "ratio", "layer_mm"), [(9.0, 3.0, 6.0, 40.0), (16.0, 6.0, 2.5, 30.0)])
def test_the_table_agrees_with_elements_between_its_nodes(
    size_mm: float, depth_mm: float, ratio: float, layer_mm: float
) -> None:
    body = Body(depth_mm / size_mm, (layer_mm - depth_mm - size_mm) / size_mm)
    punches = [(3.5, 0.0), (3.5, 5.0)]
    found = punch_compliance(body, (1.0, ratio), [(a / size_mm, x / size_mm) for a, x in punches], fineness=0.7)
    whole = half_space_compliance(3.5 / size_mm, POISSON) * layer_share(3.5 / size_mm, body.layer, POISSON)
    radius, distance = np.array(punches).T
    looked_up = taken_share(Sphere(0.0, 0.0, size_mm, depth_mm, ratio), layer_mm, radius, distance)
    assert looked_up == pytest.approx((found[0] - found[1]) / whole, rel=0.03)


@pytest.mark.long
def test_a_mesh_twice_as_dense_changes_the_nodule_s_part_by_four_percent_at_most() -> None:
    body, punches = Body(0.3, 1.0), [(0.3, 0.0), (0.3, 0.6)]
    coarse, dense = (
        punch_compliance(body, (1.0, 5.0), punches, fineness=fineness, harmonics=5) for fineness in (0.7, 1.0)
    )
    assert coarse[0] - coarse[1] == pytest.approx(dense[0] - dense[1], rel=0.04)


def test_share_falls_with_depth_and_distance_and_grows_with_size_and_ratio() -> None:
    def share(size: float = 10.0, depth: float = 4.0, ratio: float = 5.0, distance: float = 0.0) -> float:
        found = taken_share(Sphere(0.0, 0.0, size, depth, ratio), 45.0, np.array([4.0]), np.array([distance]))
        return float(found[0])

    for changed in ("depth", "distance"):
        values = [share(**{changed: value}) for value in (2.0, 4.0, 7.0, 11.0, 15.0)]
        assert np.all(np.diff(values) < 0.0), changed
    assert np.all(np.diff([share(size=value) for value in (4.0, 6.0, 10.0, 15.0, 20.0)]) > 0.0)
    assert np.all(np.diff([share(ratio=value) for value in (1.3, 2.0, 4.0, 10.0, 20.0)]) > 0.0)
    assert share(distance=200.0) == 0.0
    assert 0.0 < share(size=20.0, depth=2.0, ratio=20.0) <= LARGEST_SHARE


def test_force_on_a_deep_linear_ground_is_that_of_hertz() -> None:
    ground = Ground(young_kpa=20.0, exponent=1.5, layer_mm=1e4, probe_mm=6.0)
    depths, force = force_at(ground, [], PLACE, PLACE, 3.0)
    hertz = 4.0 / 3.0 * 20e-3 / (1.0 - POISSON**2) * np.sqrt(6.0) * depths**1.5
    assert force[0] == pytest.approx(hertz, rel=0.01, abs=1e-4)


def test_force_grows_with_the_exponent_and_a_nodule_adds_to_it() -> None:
    ground = Ground(young_kpa=10.0, exponent=2.2, layer_mm=1e4, probe_mm=6.0)
    depths, force = force_at(ground, [], PLACE, PLACE, 4.0)
    half, whole = np.interp([2.0, 4.0], depths, force[0])
    assert whole / half == pytest.approx(2.0**2.2, rel=0.01)
    nodule = Sphere(0.0, 0.0, 12.0, 3.0, 8.0)
    thin = Ground(young_kpa=10.0, exponent=2.2, layer_mm=30.0, probe_mm=6.0)
    _, plain = force_at(thin, [], PLACE, PLACE, 4.0)
    _, above = force_at(thin, [nodule], np.array([0.0, 8.0, 40.0]), np.zeros(3), 4.0)
    assert above[0, -1] > above[1, -1] > above[2, -1]
    assert above[2] == pytest.approx(plain[0], rel=1e-3)
    assert 1.2 < above[0, -1] / plain[0, -1] < 2.5
