"""A movement of the patient is noticed by repeated touches; breathing is none, and a sideways one may be missed."""

import math
import pickle

import pytest

from common.fingers import FINGERS
from common.wire.messages import NO_TOUCH, TouchRow
from operator_site.console import texts
from operator_site.console.map.patient_shift import Contact, PatientShift
from operator_site.console.map.tactile_map import STALE_M, TactileMap
from operator_site.console.model import Console
from operator_site.console.web.page_state import page_state
from tests.unit.operator_site.console.map.shifted_phantom import contacts, noticed, packets
from tests.unit.operator_site.console.touch_rows import hand, row, sample

SEEDS = range(6)


@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize(("by_m", "within"), [(0.002, 10), (0.005, 6), (-0.010, 6)])
def test_a_movement_along_the_normal_is_noticed(curved: bool, by_m: float, within: int) -> None:
    for seed in SEEDS:
        found = noticed(seed, "normal", by_m, curved=curved, breath_m=0.0)
        assert found is not None
        assert 1 <= found.after <= within
        assert found.movement.by_m is not None
        assert found.movement.by_m == pytest.approx(by_m, rel=0.6)


def test_a_movement_beyond_the_breath_is_noticed() -> None:
    for seed in SEEDS:
        found = noticed(seed, "normal", 0.005, curved=False, breath_m=0.001)
        assert found is not None
        assert 1 <= found.after <= 8


@pytest.mark.long
@pytest.mark.parametrize("breath_m", [0.0, 0.001])
def test_breathing_is_no_movement(breath_m: float) -> None:
    for seed in SEEDS:
        assert noticed(seed, "normal", 0.0, curved=False, breath_m=breath_m, before=120) is None


def test_a_movement_sideways_over_a_flat_surface_is_not_noticed() -> None:
    assert noticed(0, "sideways", 0.010, curved=False, breath_m=0.0) is None


def test_one_wrong_height_is_no_movement() -> None:
    watch = PatientShift()
    for number, contact in enumerate(contacts(3, "normal", 0.0, curved=False, breath_m=0.0)):
        wrong_m = 0.008 if number == 50 else 0.0
        assert watch.take(contact._replace(z_m=contact.z_m + wrong_m)) is None


def test_a_turn_is_said_without_a_distance() -> None:
    watch = PatientShift()
    found = []
    for number, contact in enumerate(contacts(1, "normal", 0.0, curved=False, breath_m=0.0)):
        turned_m = 0.30 * contact.x_m if number >= 60 else 0.0
        found.append(watch.take(contact._replace(z_m=contact.z_m + turned_m)))
    movements = [movement for movement in found if movement is not None]
    assert movements
    assert movements[0].by_m is None


def test_after_a_movement_the_new_place_is_the_known_one() -> None:
    watch = PatientShift()
    made = list(contacts(0, "normal", 0.005, curved=False, breath_m=0.0, after=120))
    found = [movement for contact in made if (movement := watch.take(contact)) is not None]
    assert len(found) == 1
    assert watch.movement == found[0]
    again = pickle.loads(pickle.dumps(watch))
    last = made[-1]
    for number in range(6):
        moved = again.take(Contact(last.t_s + number, 0.0, 0.0, last.z_m - 0.005))
        if moved is not None:
            break
    assert moved is not None
    assert moved.by_m == pytest.approx(-0.005, rel=0.6)


def rests(watch: PatientShift, t_s: float, touching: TouchRow) -> None:
    index = {"index": touching}
    for number in range(5):
        watch.step(t_s + 0.1 * number, hand(**index))
    watch.step(t_s + 0.6, [NO_TOUCH] * len(FINGERS))


def test_resting_fingers_with_a_known_surface_are_contacts_and_strokes_are_none() -> None:
    known = {"stiffness_n_m": 600.0, "stiffness_ln_sd": 0.05}
    watch = PatientShift()
    for number in range(12):
        place = 0.001 * (number % 3), 0.001 * (number % 4)
        rests(watch, float(number), row(1, *place, surface_z_m=0.001, **known))
    assert watch.compared > 0
    before = watch.compared
    rests(watch, 20.0, row(1, 0.0, 0.0, surface_z_m=0.009, stiffness_n_m=600.0))
    assert watch.compared == before, "its surface is not known"
    for step in range(5):
        watch.step(30.0 + step, hand(index=row(1, 0.004 * step, 0.0, surface_z_m=0.009, **known)))
    watch.step(36.0, [NO_TOUCH] * len(FINGERS))
    assert watch.compared == before, "a stroke"


def test_squares_that_were_felt_before_the_movement_are_stale_until_they_are_felt_again() -> None:
    surface = TactileMap()
    for number, x_m in enumerate((0.001, 0.021, 0.041)):
        surface.take(sample("stiffness", number, x_m, 0.001, math.log(600.0), 0.01))
    assert surface.stale() == []
    surface.moved_s = 1.5
    assert surface.stale() == [(0.0, 0.0), (5 * STALE_M, 0.0)]
    for number in range(3, 30):
        surface.take(sample("stiffness", number, 0.001, 0.001, math.log(600.0), 0.01))
    assert surface.stale() == [(5 * STALE_M, 0.0)]


@pytest.mark.long
def test_the_page_gets_words_and_squares() -> None:
    console = Console()
    for at_ns, packet in packets(0, 0.005):
        console.take("operator/touch", at_ns, packet)
    state = page_state(console, 300.0, lambda _: True, "operator.toml")["map"]
    assert state["moved"] == "Patient moved by about 5 mm towards the hand. Striped: felt before."
    assert state["stale_mm"]
    assert all(len(corner) == 2 for corner in state["stale_mm"])
    console.begin_map()
    state = page_state(console, 300.0, lambda _: True, "operator.toml")["map"]
    assert (state["moved"], state["stale_mm"]) == (None, [])


def test_a_turn_has_no_distance_in_words() -> None:
    assert texts.moved(None) == "Patient turned or moved sideways. Striped: felt before."
    assert texts.moved(-0.0031) == "Patient moved by about 3 mm away from the hand. Striped: felt before."
