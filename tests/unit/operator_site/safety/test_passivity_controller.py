"""A port gives out at most its input, PRODUCED_J and the forgiven energy; a sound contact is not limited."""

import itertools
import math
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import FORGIVEN_W, PRODUCED_J
from operator_site.safety.passivity_controller import (
    FADE_S,
    FASTEST_M_S,
    LONGEST_STEP_S,
    MOST_FORCES,
    PassivityController,
)

T = 0.001
STIFFEST_N_M = 1000.0
KEPT_J = 0.005
AT_REST_N = math.sqrt(2.0 * STIFFEST_N_M * PRODUCED_J)
"""What may be shown to a finger that has put in nothing."""


class Finger:
    """A finger on a port, moved by the test; `wanted_n` is what is asked for."""

    def __init__(self, **about: float) -> None:
        self.port = PassivityController(STIFFEST_N_M, KEPT_J, **about)
        self.tick, self.t_s, self.z_m, self.force_n = 0, 0.0, 0.0, 0.0
        self.out_j = 0.0
        self.port.observe(0.0, 0.0)

    def move(self, rise_m: float, wanted_n: float, ticks: int = 1) -> None:
        for _ in range(ticks):
            self.tick += 1
            self.t_s = T * self.tick
            self.z_m += rise_m
            self.out_j += self.force_n * rise_m
            self.port.observe(self.t_s, self.z_m)
            self.force_n = min(wanted_n, self.port.limit_n())
            self.port.command(self.t_s, self.force_n)


def test_the_work_of_the_held_force_is_counted() -> None:
    finger = Finger()
    finger.move(0.0, 0.5)
    finger.move(-1e-4, 0.5, 20)
    assert finger.port.account_j == pytest.approx(0.5 * 20e-4)
    finger.move(1e-4, 0.5, 10)
    assert finger.port.account_j == pytest.approx(0.5 * 10e-4)
    assert finger.port.produced_j == finger.port.most_produced_j == 0.0
    damped = Finger(damping_n_s_m=2.0)
    damped.move(-1e-4, 0.0, 10)
    assert damped.port.account_j == pytest.approx(2.0 * 1e-8 / T * 10), "the device's own damping takes its part"


TICK_S = 1 / 64


def pushed(*forces_n: float, delay_s: float = 0.0) -> PassivityController:
    """A port that has shown a force for a tick each, the first from 0 s on, since its first height there."""
    port = PassivityController(STIFFEST_N_M, 1.0, delay_s=delay_s)
    port.observe(0.0, 0.0)
    for tick, force_n in enumerate(forces_n):
        port.command(TICK_S * tick, force_n)
    return port


@pytest.mark.parametrize(("late_ticks", "mean_n"), [(0.0, 2.0), (1.0, 1.5), (1.5, 0.875), (3.0, 0.0)])
def test_each_force_counts_for_as_long_as_it_acted(late_ticks: float, mean_n: float) -> None:
    port = pushed(0.0, 1.0, 5.0, 2.0, 7.0, delay_s=TICK_S * late_ticks)
    port.observe(4 * TICK_S, -0.5)
    assert port.account_j == 0.0, "no finger is as fast"
    port = pushed(0.0, 1.0, 5.0, 2.0, 7.0, delay_s=TICK_S * late_ticks)
    port.observe(4 * TICK_S, -TICK_S)
    assert port.account_j == mean_n * TICK_S
    port.observe(5 * TICK_S, -2 * TICK_S)
    acts_n = {0.0: 7.0, 1.0: 2.0, 1.5: 3.5, 3.0: 1.0}[late_ticks]
    assert port.account_j == (mean_n + acts_n) * TICK_S


def test_the_account_starts_without_force_and_with_the_allowed_energy() -> None:
    port = PassivityController(STIFFEST_N_M, 1.0)
    assert port.limit_n() == pytest.approx(AT_REST_N)
    port.observe(0.0, 0.0)
    port.command(TICK_S, 3.0)
    port.observe(2 * TICK_S, -TICK_S)
    assert port.account_j == 1.5 * TICK_S


def test_a_force_is_remembered_after_any_number_of_zero_commands() -> None:
    port = pushed(1.0)
    for number in range(2 * MOST_FORCES):
        port.command(TICK_S + 1e-5 * number, 0.0)
    port.observe(4 * TICK_S, -TICK_S)
    assert port.account_j == 0.25 * TICK_S


def test_after_a_clock_was_set_back_the_newest_force_acts() -> None:
    port = pushed(0.0, 1.0, 5.0, 2.0)
    port.command(TICK_S, 3.0)
    port.observe(4 * TICK_S, -TICK_S)
    assert port.account_j == 0.75 * 3.0 * TICK_S


@pytest.mark.parametrize(
    ("dt_s", "rise_m", "counts"),
    [
        (LONGEST_STEP_S, -0.01, True),
        (math.nextafter(LONGEST_STEP_S, 1.0), -0.01, False),
        (0.0625, -FASTEST_M_S * 0.0625, True),
        (0.0625, math.nextafter(-FASTEST_M_S * 0.0625, -1.0), False),
        (1e-6, -1e-6, True),
        (-0.0625, -0.001, False),
    ],
)
@pytest.mark.parametrize("owed_j", [0.0, 0.015625])
def test_a_step_that_is_too_long_or_too_fast_counts_nothing_and_forgives_nothing(
    dt_s: float, rise_m: float, counts: bool, owed_j: float
) -> None:
    port = pushed(2.0)
    port.observe(TICK_S, owed_j / 2.0)
    port.observe(0.0, 0.0)  # set back
    port.observe(dt_s, rise_m)
    assert port.account_j == pytest.approx(-owed_j - 2.0 * rise_m * counts, abs=1e-12)
    assert port.most_produced_j == owed_j


def test_output_ends_when_the_energy_is_spent() -> None:
    finger = Finger()
    finger.move(0.0, 0.9)
    finger.move(-1e-4, 0.9, 10)
    forces = []
    for _ in range(200):
        finger.move(1e-4, 10.0)
        forces.append(finger.force_n)
    assert 1.0 < forces[0] < 2.0
    assert max(forces[-20:]) < 0.02
    assert finger.out_j == pytest.approx(PRODUCED_J + FORGIVEN_W * 0.2, rel=0.05)
    assert finger.port.most_produced_j == pytest.approx(PRODUCED_J, rel=0.05)


def test_debt_is_forgiven_slowly_and_no_energy_is_given() -> None:
    finger = Finger()
    finger.move(1e-4, 10.0, 50)
    owed_j = -finger.port.account_j
    assert owed_j > 0.9 * PRODUCED_J
    finger.move(0.0, 0.0, 1000)
    assert finger.port.account_j == pytest.approx(-owed_j + FORGIVEN_W, rel=0.01)
    finger.move(0.0, 0.0, 10_000)
    assert finger.port.account_j == 0.0
    finger.move(1e-4, 10.0, 50)
    assert finger.port.account_j < 0.0
    finger.port.rest()
    assert finger.port.account_j == 0.0
    finger.move(-1e-4, 0.5, 20)
    finger.port.rest()
    assert finger.port.account_j == pytest.approx(0.5 * 19e-4, rel=0.2)


def test_spent_energy_is_earned_again_by_pressing() -> None:
    finger = Finger(damping_n_s_m=0.5)
    finger.move(0.0, 10.0)
    finger.move(2e-5, 10.0, 300)
    assert finger.force_n < 0.15
    finger.move(-1e-4, 10.0, 20)
    assert finger.force_n > 1.0


def test_work_under_a_late_force_is_counted_with_that_force() -> None:
    """Pressed in and out evenly, a late spring gives out what its delay makes: counted without it, nothing is seen."""
    delay_s, seen = 0.004, {}
    for assumed_s in (0.0, delay_s):
        port = PassivityController(STIFFEST_N_M, 1.0, delay_s=assumed_s)
        true_j = 0.0
        for tick in range(2000):
            t_s = T * tick
            depth_m, before_m, late_m = (
                0.002 + 0.002 * math.sin(30.0 * (t_s - ago_s)) for ago_s in (0.0, T, T + delay_s)
            )
            true_j += 100.0 * late_m * (before_m - depth_m) if tick else 0.0
            port.observe(t_s, -depth_m)
            port.command(t_s, 100.0 * depth_m)
        seen[assumed_s] = -port.account_j
    assert true_j > 0.001
    assert seen[delay_s] == pytest.approx(true_j, rel=0.15)
    assert seen[0.0] < 0.2 * true_j


def test_a_lost_height_is_made_up_by_the_next() -> None:
    whole, gappy = PassivityController(STIFFEST_N_M, 1.0), PassivityController(STIFFEST_N_M, 1.0)
    for tick in range(1000):
        z_m = -0.004 * math.sin(6.0 * T * tick)
        whole.observe(T * tick, z_m)
        if tick % 7 not in (3, 4, 5):
            gappy.observe(T * tick, z_m)
        else:
            gappy.observe(T * (tick - tick % 7 + 2), -0.004 * math.sin(6.0 * T * (tick - tick % 7 + 2)))  # the old one
        for port in (whole, gappy):
            port.command(T * tick, -400.0 * min(0.0, z_m))
    assert gappy.account_j == pytest.approx(whole.account_j, abs=1e-4)


@pytest.mark.parametrize(
    ("t_s", "z_m"), [(-1.0, 0.0), (0.5, 0.0), (math.nan, 0.0), (0.101, math.nan), (0.101, math.inf), (0.101, 0.02)]
)
def test_unknown_heights_restart_the_account(t_s: float, z_m: float) -> None:
    """Clock set back, standing still, a height that is none, one that no finger reaches in that time."""
    finger = Finger()
    finger.move(0.0, 0.9)
    finger.move(-1e-4, 0.9, 99)
    assert finger.port.account_j > 0.005
    finger.port.observe(t_s, z_m)
    assert finger.port.account_j == 0.0
    assert finger.port.limit_n() == pytest.approx(AT_REST_N)
    finger.port.command(t_s, 0.5)
    begin_s = 0.2 if math.isnan(t_s) else t_s
    for tick in range(1, 4):
        finger.port.observe(begin_s + T * tick, -1e-4 * tick)
        finger.port.command(begin_s + T * tick, 0.5)
    assert 0.0 <= finger.port.account_j <= 0.9 * 3e-4
    assert LONGEST_STEP_S < 0.4


def test_heights_that_jump_again_and_again_pump_nothing() -> None:
    finger = Finger()
    for _ in range(100):
        finger.move(5e-5, 10.0, 20)
        finger.z_m -= 0.01
        finger.move(0.0, 10.0)
    assert finger.out_j <= 1.05 * (PRODUCED_J + FORGIVEN_W * finger.t_s)


def test_heights_that_never_come_cost_no_memory() -> None:
    finger = Finger()
    for tick in range(1000):
        finger.port.observe(T * tick, math.nan)
        finger.port.command(T * tick, 0.1)
    assert len(pickle.dumps(finger.port)) < 40 * MOST_FORCES


def test_losses_of_a_contact_fade_and_stored_energy_stays() -> None:
    finger = Finger()
    finger.move(0.0, 4.0)
    for tick in range(1, 101):  # a spring of 400 N/m, pressed in by 10 mm
        finger.move(-1e-4, 400.0 * 1e-4 * tick)
    stored_j = 0.5 * 4.0 * 0.010
    assert finger.port.account_j == pytest.approx(stored_j, rel=0.02)
    finger.move(0.0, 4.0, 10_000)
    assert finger.port.account_j == pytest.approx(stored_j, rel=0.02)  # it rests for ten seconds, and is all there
    finger.move(0.0, 0.0, round(FADE_S / T))
    left_j = finger.port.account_j  # the surface has gone: what was put in is lost
    assert left_j - KEPT_J == pytest.approx((stored_j - KEPT_J) * math.exp(-1.0), rel=0.05)
    finger.move(0.0, 0.0, 10_000)
    assert finger.port.account_j == pytest.approx(KEPT_J, rel=0.01)


@pytest.mark.parametrize(
    ("course", "held_j"),
    [
        pytest.param([(0.0, 0.5), (-0.01, 0.5)], 0.005, id="a small force"),
        pytest.param([(0.0, 1.0), (0.01, 4.0), (-0.015, 4.0), (-0.015, 4.0)], 0.11, id="it rose before"),
        pytest.param([(0.0, 0.0), (0.02, 0.0), (-0.02, 4.0), (-0.005, 1.0)], 0.005, id="no force held it higher"),
    ],
)
def test_a_contact_holds_its_force_up_to_its_highest_place(course: list[tuple[float, float]], held_j: float) -> None:
    port, t_s, z_m = PassivityController(STIFFEST_N_M, 0.0), 0.0, 0.0
    for rise_m, force_n in course + [(0.0, course[-1][1])] * 1000:
        z_m, t_s = z_m + rise_m, t_s + TICK_S
        port.observe(t_s, z_m)
        port.command(t_s, force_n)
    assert port.account_j == pytest.approx(held_j)


moves = st.tuples(st.floats(-4e-4, 4e-4), st.floats(0.0, 10.0), st.integers(1, 40))


@given(st.lists(moves, min_size=1, max_size=25))
def test_energy_out_never_exceeds_energy_in_for_any_command(course: list[tuple[float, float, int]]) -> None:
    """But for what a tick of the stiffest wall makes: the device's own damping, not counted here, is there for that."""
    finger, sampled_j = Finger(), 0.0
    for rise_m, wanted_n, ticks in course:
        for _ in range(ticks):
            sampled_j += STIFFEST_N_M * rise_m * rise_m
            finger.move(rise_m, wanted_n)
            assert finger.force_n <= wanted_n
            assert finger.out_j <= PRODUCED_J + FORGIVEN_W * finger.t_s + 0.5 * sampled_j + 1e-12


springs = st.tuples(st.floats(50.0, STIFFEST_N_M), st.floats(0.5, 8.0), st.floats(0.0005, 0.01))


@given(springs)
def test_a_spring_within_the_bound_is_never_limited(spring: tuple[float, float, float]) -> None:
    """Any spring, pressed up to eight times a second, on a device with the damping that the bound assumes."""
    stiffness, hz, depth_m = spring
    finger = Finger(damping_n_s_m=STIFFEST_N_M * T / 2)
    finger.z_m = 0.0
    places = [0.001 - (0.001 + depth_m) * 0.5 * (1.0 - math.cos(2.0 * math.pi * hz * T * tick)) for tick in range(1000)]
    finger.move(0.001, 0.0)
    for before_m, z_m in itertools.pairwise(places):
        finger.move(z_m - before_m, min(10.0, stiffness * max(0.0, -z_m)))
        assert finger.force_n == min(10.0, stiffness * max(0.0, -z_m))
