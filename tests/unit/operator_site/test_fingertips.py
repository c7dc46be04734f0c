"""Five fingertips together: from touch parameters to requests, and through the gate."""

import math
from dataclasses import replace

import numpy as np
import pytest

from common.limits import COMFORT, FORCE_RAMP_UP_N_S
from common.scenes.materials import material
from common.wire.messages import OBJECT_UNKNOWN_SD_K, Event, EventKind, ExplorationMode, TouchRow
from operator_site.fingertips import LATEST_TAP_S, Fingertips
from operator_site.safety.gated_output import Outputs
from operator_site.safety.limit_flags import Limit
from operator_site.safety.operator_gate import OperatorGate
from operator_site.safety.sampled_wall import SampledWall
from tests.unit.operator_site.touches import INDEX, rows

DT = 0.002
WALL = SampledWall(2.0, DT, 0.004)
UP, DOWN = [0.006] * 5, [-0.002] * 5


def constants(name: str, object_c: float) -> dict[str, float]:
    m = material(name)
    return {
        "conductivity_w_mk": m.conductivity_w_mk,
        "density_kg_m3": m.density_kg_m3,
        "specific_heat_j_kgk": m.specific_heat_j_kgk,
        "object_c": object_c,
    }


class Rig:
    def __init__(self) -> None:
        self.tips = Fingertips(WALL)
        self.t_s = 3.0
        self.plate_c = [33.0] * 5
        self.out: Outputs | None = None

    def step(self, touch, z_m, events=(), speed=0.0, engaged=True, age=0.005, x_m=0.0, y_m=0.0, dt=DT, pushed_n=None):
        self.t_s += dt
        self.out = self.tips.step(
            self.t_s,
            engaged,
            rows=touch,
            events=events,
            speed_m_s=speed,
            x_m=x_m,
            y_m=y_m,
            z_m=z_m,
            pushed_n=pushed_n or (self.out.force_n if self.out else [0.0] * 5),
            plate_c=self.plate_c,
            plate_age_s=[age] * 5,
        )
        return self.out

    def run(self, seconds, touch, z_m, **more):
        return [self.step(touch, z_m, **more) for _ in range(round(seconds / DT))]


def test_free_hand_feels_nothing():
    for out in Rig().run(1.0, rows(), UP, speed=0.3):
        assert out.force_n == out.motor_rpm == [0.0] * 5


def test_force_comes_from_the_local_height():
    rig = Rig()
    touch = rows(stiffness_n_m=400.0, surface_z_m=0.001, contact=0, contact_force_n=9.0)
    rig.run(0.5, touch, UP)
    out = rig.run(0.2, touch, [0.0, -0.001, 0.002, 0.001, -0.009])[-1]
    assert out.force_n == pytest.approx([0.4, 0.8, 0.0, 0.0, 4.0], abs=1e-6)


def test_a_force_that_the_gate_holds_back_rises_again_at_the_ramp_of_an_update():
    rig, touch = Rig(), rows(stiffness_n_m=400.0)
    rig.run(0.02, touch, UP)
    assert rig.step(touch, DOWN).force_n == pytest.approx([0.8] * 5)
    for out in rig.run(0.1, touch, DOWN, pushed_n=[0.0] * 5):
        assert max(out.force_n) <= FORCE_RAMP_UP_N_S * DT + 1e-9


def test_cold_metal_is_felt_by_the_finger_that_touches_it():
    rig = Rig()
    touch = rows(
        [INDEX], stiffness_n_m=400.0, contact=1, mode=ExplorationMode.QUIESCENT, **constants("aluminium", 23.0)
    )
    start = np.array(rig.tips.skin.epidermis_c)
    out = rig.run(4.0, touch, DOWN)[-1]
    change = rig.tips.skin.epidermis_c - start
    assert change[1] < -4.0
    assert np.abs(np.delete(change, 1)).max() < 0.01
    assert out.plate_set_c[1] < 26.0
    assert out.peltier_drive[1] < -0.5  # the plate stands at 33 C and is asked to be cold


def test_contact_for_heat_is_local_or_the_remote_fingers():
    for contact, z_m, touches in ((1, UP, True), (0, DOWN, True), (0, UP, False)):
        rig = Rig()
        rig.run(0.5, rows(stiffness_n_m=400.0, contact=contact, **constants("copper", 20.0)), z_m)
        assert (rig.tips.skin.flux_w_m2[0] < -500.0) == touches


def test_a_free_hand_and_one_on_an_unknown_material_or_temperature_are_shown_the_skins_own_temperature():
    touched = rows(stiffness_n_m=400.0, contact=1, object_c=20.0)
    of_unknown_c = rows(contact=1, object_c_sd=OBJECT_UNKNOWN_SD_K, **constants("copper", 0.0))
    for touch, z_m in ((rows(), UP), (touched, DOWN), (of_unknown_c, DOWN)):
        out = Rig().run(1.0, touch, z_m)[-1]
        assert out.plate_set_c == pytest.approx([33.03] * 5, abs=0.05)


def test_rate_that_the_plate_cannot_show_is_reported():
    touch = rows(stiffness_n_m=400.0, contact=1, **constants("aluminium", 15.0))
    assert any(out.limited[0] & Limit.PLATE_RATE for out in Rig().run(0.2, touch, DOWN))


def test_events_reach_their_own_finger_once_and_only_while_engaged():
    rig = Rig()
    touch = rows(mode=ExplorationMode.TAPPING, contact=1, k_tap=4000.0, b_tap_per_s=30.0, stiffness_n_m=400.0)
    taps = [Event(1, EventKind.TAP, 1, 0, 0, 0.1), Event(2, EventKind.MATERIAL, 2, 0, 0, 0.9, "pvc")]
    out = rig.step(touch, DOWN, events=taps)
    assert [speed > 0.0 for speed in out.motor_rpm] == [False, True, False, False, False]
    assert [event.ident for event in rig.tips.impulses_played] == [1]
    outs = rig.run(0.3, touch, DOWN, events=taps)
    assert rig.tips.impulses_played == []
    assert outs[-1].motor_rpm == [0.0] * 5
    idle = Rig()
    idle.run(1.5 * LATEST_TAP_S, touch, DOWN, events=taps, engaged=False)
    assert idle.step(touch, DOWN, events=taps).motor_rpm == [0.0] * 5  # too late
    idle.tips.begin_session()
    assert idle.step(touch, DOWN, events=taps).motor_rpm[1] > 0.0


def test_a_slope_continues_below_a_hand_that_is_ahead_of_the_remote_one():
    plane = {"surface_z_m": 0.0, "x_m": 0.1, "y_m": -0.1, "slope_x": 0.1, "slope_y": -0.2, "stiffness_n_m": 300.0}
    ahead = ((0.1, -0.1, 0.0), (0.103, -0.1, 0.0003), (0.1, -0.101, 0.0002), (0.2, -0.1, 0.001), (0.0, -0.1, -0.001))
    for x_m, y_m, height_m in ahead:
        rig = Rig()
        rig.run(0.02, rows([INDEX], **plane), UP, x_m=x_m, y_m=y_m)
        shown = rig.step(rows([INDEX], **plane), DOWN, x_m=x_m, y_m=y_m)
        assert shown.force_n[1] == pytest.approx(300.0 * (0.002 + height_m), rel=1e-4)


def test_a_surface_stiffer_than_the_exoskeleton_may_show_is_reported():
    rig = Rig()
    hard, soft = rows([INDEX], stiffness_n_m=3000.0), rows([INDEX], stiffness_n_m=300.0)
    rig.run(0.02, hard, UP)
    shown = rig.step(hard, DOWN)
    assert shown.force_n[1] == pytest.approx(0.002 * WALL.stiffest_n_m)
    assert [bool(bits & Limit.STIFFNESS) for bits in shown.limited] == [False, True, False, False, False]
    assert not rig.step(soft, DOWN).limited[1] & Limit.STIFFNESS


def test_stroke_uses_the_hands_own_speed_and_force():
    rig = Rig()
    touch = rows(mode=ExplorationMode.STROKING, contact=1, k_stroke_v=5000.0, k_stroke_f=120.0, stiffness_n_m=400.0)
    rig.run(0.02, touch, UP, speed=0.1)
    rig.run(0.2, touch, DOWN, speed=0.1)
    out = rig.step(touch, DOWN, speed=-0.1)
    assert out.motor_rpm[0] == pytest.approx((5000.0 * 0.1 + 120.0 * 0.8) * 30.0 / math.pi)
    unknown = rows(mode=ExplorationMode.STROKING, contact=1, k_stroke_v=5000.0, k_stroke_f=120.0, contact_force_n=1.5)
    assert Rig().step(unknown, DOWN, speed=0.1).motor_rpm[0] == pytest.approx((500.0 + 180.0) * 30.0 / math.pi)


def test_plate_without_a_fresh_reading_or_engagement_is_not_driven():
    touch = rows(stiffness_n_m=400.0, contact=1, **constants("aluminium", 20.0))
    for changes in ({"age": math.inf}, {"engaged": False}):
        assert all(out.peltier_drive == [0.0] * 5 for out in Rig().run(0.5, touch, DOWN, **changes))


@pytest.mark.parametrize("lift_s", [0.0, 0.1])
@pytest.mark.parametrize("sd", [0.0, 0.1])
def test_a_finger_that_moves_to_another_object_feels_that_object_alone(lift_s, sd):
    rig, uncertain = Rig(), {"contact": 1, "effusivity_ln_sd": sd, "object_c_sd": sd}
    rig.run(3.0, rows(**uncertain, **constants("pvc", 23.0)), UP)
    rig.run(lift_s, rows(), UP)
    rig.run(0.1, rows(**uncertain, **constants("aluminium", 23.0)), UP)
    # An uncertain object is still the same one, which has a better estimate now.
    assert (rig.tips.skin.flux_w_m2[INDEX] < -5000.0) == (sd == 0.0)


def test_a_plate_that_had_no_drive_shows_no_earlier_touch():
    rig = Rig()
    rig.run(1.0, rows(contact=1, **constants("copper", 5.0)), UP)
    rig.run(0.1, rows(), UP, age=math.inf)
    assert min(rig.run(1.0, rows(), UP)[-1].plate_set_c) == pytest.approx(33.03, abs=0.05)


@pytest.mark.long
def test_the_whole_chain_shows_an_object_and_the_gate_corrects_nothing():
    rig, gate = Rig(), OperatorGate(COMFORT, WALL)
    touch = rows(stiffness_n_m=400.0, contact=1, mode=ExplorationMode.QUIESCENT, **constants("ceramic_tile", 23.0))
    plate, acted = np.full(5, 33.0), 0
    for tick in range(5000):
        near = tick > 500
        z_m = [max(-0.002, 0.006 - 0.05 * DT * max(0, tick - 500))] * 5
        wanted = rig.step(touch if near else rows(), z_m)
        out = gate.step(
            rig.t_s,
            True,
            0.0,
            replace(wanted, limited=[0] * 5),
            plate_measured_c=rig.plate_c,
            measurement_age_s=[0.005] * 5,
            z_m=z_m,
            height_age_s=0.0,
        )
        drive = np.array(out.peltier_drive)
        plate += DT * (drive * np.where(drive > 0.0, 4.0, 2.5) - 0.05 * (plate - 31.0))
        if tick % 5 == 4:
            rig.plate_c = [float(value) for value in plate]
        acted |= out.limited[2]
    assert out.fault is None
    assert acted == 0
    assert plate[2] == pytest.approx(out.plate_set_c[2], abs=0.1)
    assert plate[2] < 30.0


def lowered(rig: Rig, touch: list[TouchRow], speed_m_s: float, until_m: float) -> list[float]:
    """Set-points of the index finger's plate while the hand comes down from 6 mm above the surface."""
    heights = touch[INDEX].surface_z_m + np.arange(0.006, until_m, -speed_m_s * DT)
    return [rig.step(touch, [float(z_m)] * 5).plate_set_c[1] for z_m in heights]


@pytest.mark.parametrize("surface_z_m", [0.0, -0.003])
def test_the_plate_starts_before_a_contact_that_is_known_to_come(surface_z_m):
    rig = Rig()
    known = rows([INDEX], stiffness_n_m=400.0, surface_z_m=surface_z_m, **constants("aluminium", 23.0))
    rig.run(0.2, known, UP)
    at_rest = rig.step(known, UP).plate_set_c[1]
    shown = lowered(rig, known, 0.01, 0.0031)
    assert shown[-1] == pytest.approx(at_rest)  # 0.3 s before contact nothing is shown
    shown = lowered(rig, known, 0.01, 0.0005)
    assert at_rest - 2.5 * 0.3 <= shown[-1] < at_rest - 0.4
    # The hand stays up after all: the plate goes back.
    assert rig.run(0.6, known, UP)[-1].plate_set_c[1] == pytest.approx(at_rest, abs=0.02)


@pytest.mark.parametrize("unknown", [{"stiffness_n_m": 0.0}, {"conductivity_w_mk": 0.0}])
def test_without_a_known_surface_or_material_no_plate_starts_early(unknown):
    rig, touch = Rig(), rows([INDEX], **{"stiffness_n_m": 400.0, **constants("aluminium", 23.0), **unknown})
    rig.run(0.2, touch, UP)
    at_rest = rig.step(touch, UP).plate_set_c[INDEX]
    assert lowered(rig, touch, 0.01, 0.0005)[-1] == pytest.approx(at_rest, abs=1e-6)


@pytest.mark.parametrize("tick_s", [0.002, 0.01, 0.025, 0.05])
def test_the_skin_keeps_time_at_any_tick(tick_s):
    """A tick that is late, or always slow, must not slow the skin down."""
    touch = rows([INDEX], contact=1, **constants("aluminium", 23.0))
    slow, steady = Rig(), Rig()
    for _ in range(round(3.0 / tick_s) + 1):
        slow.step(touch, UP, age=0.0, dt=tick_s)
    steady.run(3.01, touch, UP)
    assert slow.tips.skin.epidermis_c[INDEX] == pytest.approx(steady.tips.skin.epidermis_c[INDEX], abs=0.02)
