import numpy as np
import pytest

from common.fingers import FINGERS
from common.scenes.materials import material
from common.scenes.scene import Scene, load_scene
from sim_sensors.physics.remote_world import RemoteWorld
from sim_sensors.physics.true_mode import FREE, QUIESCENT, STROKING

TICK_S = 0.002
UP_M = 0.006
DOWN_M = -0.0015
OFF = np.zeros(5)


class Hand:
    """Drives a world: set-points in straight lines."""

    def __init__(self, scene="materials", seed=0, fingers=FINGERS):
        self.world = RemoteWorld(load_scene(scene), seed, fingers)
        self.x_m, self.height_m = 0.0, UP_M
        self.counts = []

    def go(self, seconds, x_m=None, z_m=None, drive=OFF):
        x0, z0 = self.x_m, self.height_m
        x1, z1 = x0 if x_m is None else x_m, z0 if z_m is None else z_m
        steps = round(seconds / TICK_S)
        for step in range(1, steps + 1):
            part = step / steps
            z = np.full(5, z0 + part * (z1 - z0))
            self.world.step(TICK_S, x0 + part * (x1 - x0), 0.0, z, drive)
        self.counts.append(self.world.take_texture_counts())
        self.x_m, self.height_m = x1, z1
        return self

    def press(self, name, u=0.5):
        x_m = self.world.scene.object_named(name).x_at(u)
        return self.go(0.3, x_m=x_m).go(0.2, z_m=DOWN_M).go(0.3)


def index_of(world, name):
    return next(i for i, thing in enumerate(world.bench.objects) if thing.name == name)


def test_press_gives_the_force_of_servo_and_object_in_series():
    hand = Hand().press("pvc_plain")
    assert hand.world.force_n == pytest.approx(np.full(5, 0.0015 / (1 / 1000 + 1 / 4000)), rel=1e-3)
    assert hand.world.object_index.tolist() == [index_of(hand.world, "pvc_plain")] * 5
    assert hand.world.mode.tolist() == [QUIESCENT] * 5


def test_between_objects_there_is_nothing():
    world = Hand().go(0.3, x_m=0.005).go(0.4, z_m=DOWN_M).go(0.2).world
    assert world.force_n.tolist() == [0.0] * 5
    assert world.object_index.tolist() == [-1] * 5
    assert world.mode.tolist() == [FREE] * 5
    assert world.z_m == pytest.approx(np.full(5, DOWN_M), abs=1e-4)


@pytest.mark.long
def test_same_seed_same_world_and_another_seed_another():
    first, again, other = (Hand(seed=seed).press("wood") for seed in (3, 3, 4))
    assert np.array_equal(first.world.plate_c, again.world.plate_c)
    assert np.array_equal(first.world.ssr_counts(), again.world.ssr_counts())
    assert np.array_equal(np.hstack(first.counts), np.hstack(again.counts))
    assert first.world.take_events() == again.world.take_events()
    assert first.world.bench.objects[0].object_c != other.world.bench.objects[0].object_c


def test_what_the_hand_does_changes_nothing_of_what_was_drawn():
    still, moved = Hand(seed=5), Hand(seed=5).press("foam")
    for a, b in zip(still.world.bench.objects, moved.world.bench.objects, strict=True):
        assert (a.object_c, a.column.heat_j_m3k, a.grooves_x_m) == (b.object_c, b.column.heat_j_m3k, b.grooves_x_m)


@pytest.mark.long
def test_drawn_objects_stay_near_ambient_and_near_their_material():
    scene = load_scene("materials").model_copy(update={"pieces": "new"})
    drawn = [thing for seed in range(12) for thing in RemoteWorld(scene, seed).bench.objects]
    temperatures = np.array([thing.object_c for thing in drawn])
    assert temperatures.min() >= 20.0
    assert temperatures.max() <= 26.0
    assert temperatures.std() > 1.0
    blocks = [thing for thing in drawn if thing.name == "wood"]
    pine = material("pine")
    logs = np.log([block.column.heat_j_m3k / (pine.density_kg_m3 * pine.specific_heat_j_kgk) for block in blocks])
    assert 0.08 < logs.std() < 0.35


def test_calibrated_blocks_are_the_same_in_every_session_but_for_their_temperature():
    worlds = [RemoteWorld(load_scene("materials"), seed).bench.objects for seed in range(3)]
    for things in zip(*worlds, strict=True):
        known = things[0].material in load_scene("materials").calibrated
        assert len({thing.column.heat_j_m3k for thing in things}) == (1 if known else 3)
        assert len({thing.object_c for thing in things}) == 3


def test_a_material_of_the_scene_s_own_lies_on_the_bench_as_it_is_described():
    balsa = {"conductivity_w_mk": 0.05, "density_kg_m3": 160.0, "specific_heat_j_kgk": 1700.0}
    block = {"name": "block", "material": "balsa", "surface": "pine", "x_m": 0.0, "length_m": 0.1}
    scene = Scene.model_validate({"name": "own", "objects": [block], "materials": {"balsa": balsa}})
    for seed in range(3):
        (thing,) = RemoteWorld(scene, seed).bench.objects
        assert thing.column.heat_j_m3k == pytest.approx(160.0 * 1700.0)
        assert thing.column.half_cell_m2k_w == pytest.approx(0.5 * thing.column.cell_m[0] / 0.05)
    assert thing.material == "balsa"


def test_zones_of_one_body_share_specimen_and_temperature():
    zones = [thing for thing in RemoteWorld(load_scene("materials"), 0).bench.objects if "pvc" in thing.name]
    assert len({zone.object_c for zone in zones}) == 1
    assert len({zone.column.heat_j_m3k for zone in zones}) == 1


def test_contact_and_release_are_told_once_for_each_finger():
    hand = Hand().press("wood").go(0.3, z_m=UP_M)
    events = hand.world.take_events()
    for kind in ("contact", "release"):
        assert sorted(event.finger for event in events if event.kind == kind) == [0, 1, 2, 3, 4]
    contact = events[0]
    wood = hand.world.bench.objects[index_of(hand.world, "wood")]
    assert (contact.object, contact.material, contact.object_c) == ("wood", "pine", wood.object_c)
    assert contact.approach_m_s == pytest.approx(0.0075 / 0.2, rel=0.3)
    assert hand.world.take_events() == []


def test_stroke_crosses_every_groove_once_each_way_and_is_stroking():
    hand = Hand().press("pvc_plain", 0.8)
    hand.world.take_events()
    zone = hand.world.scene.object_named("pvc_closely")
    grooves = hand.world.bench.objects[index_of(hand.world, "pvc_closely")].grooves_x_m
    hand.go(1.2, x_m=zone.x_at(1.1))
    assert hand.world.mode.tolist() == [STROKING] * 5
    there = [event for event in hand.world.take_events() if event.finger == 1]
    hand.go(0.3)
    hand.go(1.2, x_m=zone.x_at(-0.2)).go(0.3)
    back = [event for event in hand.world.take_events() if event.finger == 1 and event.object == "pvc_closely"]
    assert len([event for event in there if event.object == "pvc_closely"]) == len(grooves) == 24
    assert len(back) == 24
    times = [event.time_s for event in there if event.object == "pvc_closely"]
    assert times == sorted(times)
    speed = (zone.x_at(1.1) - zone.x_at(0.0) + 0.2 * 0.048) / 1.2
    assert np.median(np.diff(times)) == pytest.approx(2e-3 / speed, rel=0.1)
    assert {event.mode for event in there} == {STROKING}


def test_grooves_are_pulses_at_the_sensor_and_plain_pvc_is_smooth():
    hand = Hand().press("pvc_plain", 0.05)
    hand.counts.clear()
    hand.go(0.8, x_m=hand.world.scene.object_named("pvc_plain").x_at(0.85))
    plain = np.hstack(hand.counts)[:, 800:] * 10.0 / 2048.0
    hand.counts.clear()
    hand.go(1.2, x_m=hand.world.scene.object_named("pvc_closely").x_at(1.0))
    grooved = np.hstack(hand.counts) * 10.0 / 2048.0
    assert np.abs(plain).mean() < 0.02
    assert np.all(grooved.min(axis=1) < -0.5)


def test_heater_warms_and_contact_cools():
    hand = Hand().go(1.5, drive=np.full(5, 1.0))
    assert np.all(hand.world.plate_c > 28.0)
    warm = hand.world.plate_c.copy()
    hand.press("aluminium").go(2.0)
    aluminium = hand.world.bench.objects[0].object_c
    assert np.all(np.abs(hand.world.plate_c - aluminium) < 0.4 * (warm - aluminium))


def cooled_again_k(beside_m):
    """By how much warm plates cool in a second touch of wood, so far beside the first one."""
    hand = Hand().go(2.0, drive=np.full(5, 1.0)).press("wood", u=0.2).go(2.0)
    hand.go(0.2, z_m=UP_M).go(0.4, x_m=hand.x_m + beside_m, drive=np.full(5, 1.0))
    before = hand.world.plate_c.copy()
    hand.go(0.2, z_m=DOWN_M).go(1.0)
    return float(np.mean(before - hand.world.plate_c))


@pytest.mark.long
def test_a_spot_keeps_the_heat_of_a_touch_and_the_ground_beside_it_does_not():
    again, beside, far = (cooled_again_k(beside_m) for beside_m in (0.0, 0.010, 0.040))
    assert again < 0.75 * far
    assert again < beside < far


def test_fingers_and_touches_differ():
    hand = Hand().go(2.0, drive=np.full(5, 1.0)).press("ceramic").go(1.0)
    assert np.ptp(hand.world.plate_c) > 0.1


def test_absent_fingers_stay_up_cold_and_free():
    hand = Hand(fingers=("index",)).press("wood").go(0.5, drive=np.ones(5))
    assert (hand.world.force_n > 0.3).tolist() == [False, True, False, False, False]
    assert np.all(hand.world.z_m[[0, 2, 3, 4]] > UP_M)
    assert hand.world.plate_c[[0, 2, 3, 4]] == pytest.approx(np.full(4, 23.0))
    assert {event.finger for event in hand.world.take_events()} == {1}


def test_nodule_is_stiffer_than_the_tissue_around_it():
    forces = [Hand("phantom").press(name).world.force_n.mean() for name in ("tissue", "nodule")]
    assert forces[1] > 1.5 * forces[0]


def test_measured_force_is_noisy_by_a_hundredth_of_a_newton():
    hand = Hand().press("wood")
    noise = []
    for _ in range(300):
        hand.world.step(TICK_S, hand.x_m, 0.0, np.full(5, DOWN_M), OFF)
        noise.append(hand.world.measured_force_n - hand.world.force_n)
    assert np.std(noise) == pytest.approx(0.01, rel=0.1)


def test_nothing_advances_by_being_asked():
    world = Hand().press("wood").world
    before = world.ssr_counts().copy(), world.plate_c.copy(), world.time_s
    for _ in range(10):
        world.ssr_counts(), world.ambient_counts(), world.take_texture_counts(), world.take_events()
    assert np.array_equal(before[0], world.ssr_counts())
    assert np.array_equal(before[1], world.plate_c)
    assert world.time_s == before[2]


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_set_points_must_be_finite(bad):
    world = Hand().world
    up = np.full(5, UP_M)
    with pytest.raises(ValueError, match="finite"):
        world.step(TICK_S, bad, 0.0, up, OFF)
    with pytest.raises(ValueError, match="finite"):
        world.step(TICK_S, 0.0, 0.0, np.array([bad, 0, 0, 0, 0]), OFF)
    with pytest.raises(ValueError, match="finite"):
        world.step(TICK_S, 0.0, 0.0, up, np.array([bad, 0, 0, 0, 0]))


def test_bad_step_and_unknown_finger_are_refused():
    with pytest.raises(ValueError, match="dt_s"):
        Hand().world.step(0.1, 0.0, 0.0, np.zeros(5), OFF)
    with pytest.raises(ValueError, match="unknown finger 'toe'"):
        RemoteWorld(load_scene("materials"), 0, ("toe",))
