"""New models enter a contact without energy of their own, and never push a finger out."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import ACCOUNT_J, FINGER_FORCE_N, FORCE_RAMP_UP_N_S, FORGIVEN_W
from operator_site.force.passive_contact import LENT_J, RESTED_J, PassiveContact
from operator_site.safety.sampled_wall import SampledWall

T = 0.001
DEVICE_NS_M = 0.5
WALL = SampledWall(DEVICE_NS_M, T)
"""1000 N/m."""
ROUNDING_J = 1e-9


def test_a_model_known_before_contact_is_a_spring():
    contact = PassiveContact(WALL)
    contact.step(0.0, 0.001, 0.0, 400.0)
    assert [contact.step(T * i, -0.001 * i, 0.0, 400.0) for i in (1, 2, 1)] == pytest.approx([0.4, 0.8, 0.0])


def test_a_wall_is_shown_up_to_the_stiffness_of_the_device_and_the_limit_is_reported():
    contact = PassiveContact(WALL)
    contact.step(0.0, 0.001, 0.0, 5000.0)
    assert contact.step(T, -0.001, 0.0, 5000.0) == pytest.approx(WALL.stiffest_n_m * 0.001)
    assert contact.capped
    contact.step(2 * T, -0.001, 0.0, 900.0)
    assert not contact.capped


@pytest.mark.parametrize(("stiffness", "left"), [(100.0, 0.45), (600.0, 0.2), (5000.0, 0.0)])
def test_damping_is_shown_as_far_as_the_stiffness_leaves_room_and_never_pulls(stiffness, left):
    assert WALL.damping_left_n_s_m(min(stiffness, WALL.stiffest_n_m)) == pytest.approx(left)
    forces = []
    for damping, speed in ((0.0, 0.0), (10.0, 0.1), (10.0, -0.1)):
        contact = PassiveContact(WALL)
        contact.step(0.0, 0.001, 0.0, stiffness)
        forces.append(contact.step(T, -0.0005, 0.0, stiffness, damping, speed))
    assert forces[1] - forces[0] == pytest.approx(0.1 * left)
    assert forces[2] == pytest.approx(max(0.0, forces[0] - 0.1 * left))
    contact = PassiveContact(WALL)
    contact.step(0.0, 0.001, 0.0, stiffness)
    assert contact.step(T, 0.0005, 0.0, stiffness, 10.0, 0.1) == 0.0, "above the surface nothing damps"


def pressed(stiffness: float = 400.0, depth_m: float = 0.002) -> tuple[PassiveContact, float]:
    """A finger that came down slowly."""
    contact, t_s = PassiveContact(WALL), 0.0
    for i in range(201):
        t_s = T * i
        contact.step(t_s, 0.001 - (0.001 + depth_m) * i / 200, 0.0, stiffness)
    return contact, t_s


@pytest.mark.parametrize(("surface_m", "stiffness"), [(0.003, 400.0), (0.0, 3000.0), (0.003, 3000.0), (0.01, 50.0)])
def test_a_still_finger_is_never_pressed_harder_than_it_pressed_beyond_its_account(surface_m, stiffness):
    contact, t_s = pressed()
    account_j, before = contact.account_j, contact.step(t_s + T, -0.002, 0.0, 400.0)
    stored = before**2 / 2 / 400.0
    for i in range(2, 500):
        force = contact.step(t_s + T * i, -0.002, surface_m, stiffness)
        assert force - before <= FORCE_RAMP_UP_N_S * T + 1e-9
        before = force
    lent_j = LENT_J + FORGIVEN_W * 0.5
    assert force**2 / 2 / contact.stiffness_n_m <= stored + max(0.0, account_j) + lent_j + ROUNDING_J


def test_a_surface_first_known_around_the_finger_is_felt_softly_and_fully_on_pressing():
    contact = PassiveContact(WALL)
    forces = [contact.step(T * i, -0.005, 0.0, 400.0 if i > 5 else 0.0) for i in range(50)]
    assert all(after - before <= FORCE_RAMP_UP_N_S * T + 1e-9 for before, after in itertools.pairwise(forces))
    lent_n = math.sqrt(2.0 * 400.0 * LENT_J)
    assert forces[-1] == pytest.approx(lent_n, rel=0.02)
    assert contact.step(50 * T, -0.007, 0.0, 400.0) >= lent_n + 0.8 - 1e-9
    for i in range(1, 101):  # lifted, it takes the true surface along
        contact.step((50 + i) * T, -0.007 + 1e-4 * i, 0.0, 400.0)
    assert contact.surface_m == pytest.approx(0.0, abs=1e-4)


def test_an_interrupted_press_is_felt_again_without_lifting_after_any_number_of_interruptions():
    """What is owed is forgiven while no force acts; while one does, the surface does not creep."""
    contact, t_s, shown_n = PassiveContact(WALL), 0.0, []
    for _ in range(10):
        for known, seconds in ((False, 2.5), (True, 1.0)):
            forces = []
            for _ in range(round(seconds / T)):
                t_s += T
                forces.append(contact.step(t_s, -0.002, 0.0, 400.0 if known else 0.0))
        assert forces[-1] == pytest.approx(forces[100])
        shown_n.append(forces[-1])
    assert shown_n == pytest.approx([math.sqrt(2.0 * 400.0 * LENT_J)] * 10)


def test_outputs_at_rest_start_with_a_loan_and_without_debt():
    contact = PassiveContact(WALL)
    for i in range(10):
        contact.step(T * i, -0.003, 0.0, 400.0)
    contact.let_through(0.0)
    contact.account_j = -LENT_J
    contact.rest()
    assert contact.account_j == RESTED_J
    forces = [contact.step(0.01 + T * i, -0.003, 0.0, 400.0) for i in range(100)]
    assert forces[-1] == pytest.approx(math.sqrt(2.0 * 400.0 * (RESTED_J + LENT_J)))
    contact.account_j = ACCOUNT_J
    contact.rest()
    assert contact.account_j == ACCOUNT_J


def test_a_loan_is_forgiven_slowly_while_no_force_acts() -> None:
    contact = PassiveContact(WALL)
    contact.step(0.0, 0.002, 0.0, 400.0)
    contact.account_j = -LENT_J
    for i in range(1, 1001):
        contact.step(T * i, 0.002, 0.0, 400.0)
    assert contact.account_j == pytest.approx(-LENT_J + FORGIVEN_W, rel=1e-6)


def test_a_surface_that_sinks_pays_for_rising_again():
    contact, t_s = pressed(depth_m=0.004)
    heights = []
    for i in range(1, 6001):  # breathes 1 mm, and the finger goes along
        breath = -0.001 * (0.5 - 0.5 * math.cos(2.0 * math.pi * i / 3000))
        contact.step(t_s + T * i, breath - 0.004, breath, 400.0)
        heights.append(contact.surface_m)
    assert max(heights[3000:]) - min(heights[3000:]) == pytest.approx(0.001, rel=0.1)
    assert contact.account_j <= ACCOUNT_J


def test_an_unknown_surface_or_a_standstill_releases():
    contact, t_s = pressed()
    forces = [contact.step(t_s + T * i, -0.002, math.nan, 400.0) for i in range(1, 20)]
    assert forces[-1] == 0.0
    assert all(after <= before for before, after in itertools.pairwise(forces))
    contact, t_s = pressed()
    assert contact.step(t_s, -0.002, 0.0, 400.0) == pytest.approx(0.8), "the same moment again is no pause"
    assert contact.step(t_s + 1.0, -0.002, 0.0, 400.0) == 0.0
    assert contact.step(t_s + 1.001, math.nan, 0.0, 400.0) == 0.0


def test_force_that_was_not_applied_is_not_returned():
    """A finger that pressed unfelt, as before engaging, finds the surface where it is."""
    contact, t_s = pressed()
    assert contact.step(t_s + T, -0.002, 0.0, 400.0) == pytest.approx(0.8)
    contact.let_through(0.3)
    assert contact.step(t_s + 2 * T, -0.002, -0.01, 400.0) <= 0.3
    contact.let_through(0.0)
    contact.account_j = -LENT_J
    forces = [contact.step(t_s + (3 + i) * T, -0.002, 0.0, 400.0) for i in range(100)]
    assert forces[-1] <= math.sqrt(2.0 * 400.0 * FORGIVEN_W * 0.1) + 1e-9
    contact.let_through(0.0)
    assert contact.step(t_s + 0.11, -0.0025, 0.0, 400.0) > 0.0, "pressing on, it is felt again"


def test_a_surface_that_may_not_push_costs_nothing():
    """A finger that waits in a surface for the session is felt as soon as it begins: its account was not spent."""
    contact, t_s = pressed()
    contact.let_through(0.0)
    before_j = contact.account_j
    for i in range(1, 1000):
        assert contact.step(t_s + T * i, -0.002, 0.0, 400.0) <= FORCE_RAMP_UP_N_S * T + 1e-9
        contact.let_through(0.0)
    assert contact.account_j == pytest.approx(before_j)
    forces = [contact.step(t_s + 1.0 + T * i, -0.002, 0.0, 400.0) for i in range(100)]
    assert 0.5 < forces[-1] <= 0.8 + 1e-9


models = st.tuples(st.floats(-0.02, 0.02), st.floats(-100.0, 5000.0, width=32), st.integers(1, 30))
"""Surface, m; stiffness, N/m, as a packet can carry it; and how many ticks it lasts."""


@given(
    st.lists(models, min_size=1, max_size=12),
    st.lists(st.floats(-0.01, 0.01), min_size=1, max_size=12),
    st.floats(0.0, 20.0),
    st.lists(st.floats(0.0, 10.0), min_size=1, max_size=12),
)
def test_updates_never_give_a_finger_more_than_it_put_in(models, places, damping, ceilings):
    """Whatever models, finger and gate do, and in what order: no net energy beyond what sampling itself makes."""
    contact, t_s, z_m, force, energy_j, sampled_j = PassiveContact(WALL), 0.0, 0.01, 0.0, 0.0, 0.0
    turns = zip(models, itertools.cycle(places), itertools.cycle(ceilings), strict=False)
    for (surface_m, stiffness, ticks), target, ceiling in turns:
        for _ in range(ticks):
            descent = min(2e-4, max(-2e-4, z_m - target))
            z_m -= descent
            energy_j += force * descent  # put in by the finger, at the force held
            sampled_j += DEVICE_NS_M * descent**2 / T  # at least what holding a force makes: the device takes it
            t_s += T
            contact.let_through(force)
            wanted = contact.step(t_s, z_m, surface_m, stiffness, damping, descent / T)
            assert 0.0 <= wanted <= FINGER_FORCE_N
            force = min(ceiling, wanted)
            assert energy_j >= -sampled_j - LENT_J - FORGIVEN_W * t_s - ROUNDING_J


@given(st.lists(models, min_size=1, max_size=12))
def test_a_finger_pressed_by_a_steady_hand_is_never_kicked_out(models):
    """A light finger (0.1 kg, held by 1 N only) that came to rest inside stays inside whatever the model says."""
    contact, t_s, z_m, speed = PassiveContact(WALL), 0.0, -0.002, 0.0
    contact.step(0.0, z_m, 0.0, 0.0)
    for surface_m, stiffness, ticks in models:
        for _ in range(10 * ticks):
            t_s += T
            force = contact.step(t_s, z_m, surface_m, stiffness)
            speed += T * (force - 1.0 - 20.0 * speed) / 0.1  # upwards
            z_m += T * speed
            assert z_m <= -0.002 + 1e-3
