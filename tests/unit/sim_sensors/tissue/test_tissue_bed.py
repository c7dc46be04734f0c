"""Soft tissue under the fingers of a session."""

import math

import numpy as np
import pytest

from common.fingers import FINGER_Y_M
from common.scenes.scene import load_scene
from sim_sensors.operator_hand.hand_plan import HandPlan
from sim_sensors.physics.remote_world import RemoteWorld
from sim_sensors.tissue.tissue_bed import TissueBed

STILL = (0.0, 0.0)
SCENES = ("phantom_nodules", "abdomen")


def bed_of(scene: str = "phantom_nodules", seed: int = 0, **changes: object) -> TissueBed:
    thing = load_scene(scene).objects[0]
    assert thing.tissue is not None
    return TissueBed(thing, thing.tissue.model_copy(update=changes), np.random.default_rng(seed))


@pytest.mark.parametrize("scene", SCENES)
def test_palpation_takes_less_than_two_minutes_and_covers_the_nodules(scene: str) -> None:
    loaded = load_scene(scene)
    plan = HandPlan(loaded, np.ones(5, dtype=bool), np.random.default_rng(0))
    assert 100.0 < plan.seconds < 120.0
    pressed = [
        (segment.to_x_m, segment.to_y_m + finger)
        for segment in plan.segments
        if segment.act == "hold"
        for finger in FINGER_Y_M
    ]
    for nodule in loaded.nodules:
        assert min(math.dist(place, (nodule.x_m, nodule.y_m)) for place in pressed) < 4.0e-3


def test_stiffness_is_the_object_s_at_2_mm_and_grows_with_the_exponent() -> None:
    bed = bed_of(variation=0.0, nodules=(), layer_m=0.1, exponent=2.0)
    stiffness = [bed.under(0.0, 0.0, 0.0, -depth, STILL)[1] for depth in (0.001, 0.002, 0.004)]
    assert stiffness[1] == pytest.approx(load_scene("phantom_nodules").objects[0].stiffness, rel=1e-3)
    assert stiffness[2] / stiffness[0] == pytest.approx(4.0, rel=0.1)


def test_a_nodule_is_stiffer_than_its_surroundings_at_its_place_only() -> None:
    bed = bed_of(variation=0.0)
    for nodule in load_scene("phantom_nodules").nodules:
        there, beside = (bed.under(0.0, nodule.x_m + away, nodule.y_m, -0.003, STILL)[1] for away in (0.0, 0.020))
        assert there > 1.3 * beside


def test_the_surface_slopes_and_breathes() -> None:
    bed = bed_of(tilt_deg=(1.0, 0.0), breath_m=0.001, breaths_per_min=15.0)
    level = bed.under(0.0, 0.0, 0.0, 0.0, STILL)[0]
    assert bed.under(0.0, 0.030, 0.0, 0.0, STILL)[0] - level == pytest.approx(0.030 * math.tan(math.radians(1.0)))
    assert bed.under(1.0, 0.0, 0.0, 0.0, STILL)[0] - level == pytest.approx(0.001)
    assert bed.under(3.0, 0.0, 0.0, 0.0, STILL)[0] - level == pytest.approx(-0.001)


@pytest.mark.long
def test_a_stroke_drags_the_tissue_along_by_friction() -> None:
    nodule = load_scene("phantom_nodules").nodules[0]
    place = nodule.x_m + 0.5 * nodule.size_m, nodule.y_m
    slippery, sticky = (bed_of(variation=0.0, friction=friction) for friction in (0.0, 0.5))
    assert slippery.under(0.0, *place, -0.003, (0.05, 0.0)) == slippery.under(0.0, *place, -0.003, STILL)
    # The tissue beneath the finger lags behind a stroke away from the nodule, so that the nodule is nearer.
    assert sticky.under(0.0, *place, -0.003, (0.05, 0.0))[1] > sticky.under(0.0, *place, -0.003, STILL)[1]
    assert sticky.under(0.0, *place, -0.003, (-0.05, 0.0))[1] < sticky.under(0.0, *place, -0.003, STILL)[1]


def test_variation_has_its_deviation_and_comes_from_the_seed() -> None:
    first, again, other = (bed_of(seed=seed, nodules=(), variation=0.1) for seed in (1, 1, 2))
    line = np.linspace(-0.06, 0.06, 40)
    values = [[bed.under(0.0, x, y, -0.002, STILL)[1] for x in line for y in line] for bed in (first, again, other)]
    assert values[0] == values[1] != values[2]
    assert 0.05 < float(np.std(np.log(values[0]))) < 0.16


@pytest.mark.parametrize("scene", SCENES)
def test_a_pressed_finger_comes_to_rest_at_the_force_of_its_depth(scene: str) -> None:
    world = RemoteWorld(load_scene(scene), 0)
    for height_m in (0.006, -0.004):
        for _ in range(400):
            world.step(0.002, 0.0, 0.0, np.full(5, height_m), np.zeros(5))
    bed = world.bench.objects[0].bed
    assert bed is not None
    for finger, away_m in enumerate(FINGER_Y_M):
        surface_m, stiffness_n_m = bed.under(world.time_s, world.x_m, away_m, float(world.z_m[finger]), STILL)
        assert world.force_n[finger] == pytest.approx(stiffness_n_m * (surface_m - world.z_m[finger]), rel=0.05)
        assert 0.5 < world.force_n[finger] < 3.0
