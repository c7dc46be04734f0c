"""The plate on an object against the closed form, a bar of finite volumes, heat balances and finite differences."""

import numpy as np
import pytest

from remote_site.thermal.touch_model import Contacts, SensorConstants, TouchModel
from tests.unit.remote_site.made_touches import PLATE_J_M2K, MadeSensor, closed_form, plate_courses

LEAK_PER_S, LAG_S = 0.04, 0.3
FIRM_N = 1e9
"""A force at which the contact conducts all it can."""
OBJECTS = {"metal": (7.0, 1.1), "stone": (0.95, 0.86), "plastic": (0.24, 0.45), "foam": (0.02, 0.08)}
"""Effusivity, 1/sqrt(s), and conductance, 1/s, over the plate's heat capacity."""
TIMES_S = 0.01 * np.arange(1, 701)


def model(effusivity, conductance, lag_s=LAG_S, leak_per_s=LEAK_PER_S, slab_s=np.inf):
    contacts = Contacts(np.log([effusivity]), np.log([conductance]), np.array([slab_s]))
    return TouchModel(SensorConstants(leak_per_s, 0.3), contacts, np.array([0]), np.log([lag_s]))


def courses(touch, force_n=FIRM_N, steps=700, dt_s=0.01):
    found = np.empty((steps, *touch.courses.shape))
    for k in range(steps):
        touch.advance((dt_s,), np.array([force_n]))
        found[k] = touch.courses
    return found


@pytest.mark.long
@pytest.mark.parametrize("name", OBJECTS)
@pytest.mark.parametrize("lag_s", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("leak_per_s", [0.0, 0.06])
def test_the_closed_form(name, lag_s, leak_per_s):
    found = courses(model(*OBJECTS[name], lag_s, leak_per_s))[:, 0, :3]
    # the trapezoidal rule errs by (step / lag)^2 / 12 of a step that the plate takes at most
    allowed = 1e-4 + (0.01 / lag_s) ** 2 / 12.0
    assert found == pytest.approx(closed_form(TIMES_S, *OBJECTS[name], leak_per_s, lag_s), abs=allowed)


@pytest.mark.long
@pytest.mark.parametrize("slab_s", [0.3, 2.0, 20.0])
def test_a_slab_is_a_bar_of_finite_volumes(slab_s):
    sensor = MadeSensor(leak_w_m2k=LEAK_PER_S * PLATE_J_M2K, lag_s=LAG_S)
    effusivity, conductance = OBJECTS["metal"]
    object_c, start_c = 20.0, 33.0
    bar = plate_courses(
        np.array([effusivity * PLATE_J_M2K]),
        np.array([conductance * PLATE_J_M2K]),
        np.array([object_c]),
        np.array([start_c]),
        7.0,
        sensor,
        slab_s,
        lambda t_s: np.full_like(t_s, 1.2),
    )[0]
    back_c = 23.0 + sensor.back_share * (start_c - 23.0)
    found = courses(model(effusivity, conductance, slab_s=slab_s), 1.2)[:, 0, :3]
    assert start_c + found @ [object_c - start_c, 0.0, back_c - start_c] == pytest.approx(bar, abs=0.005)


@pytest.mark.long
@pytest.mark.parametrize("slab_s", [0.3, 1.0, 3.0])
def test_plate_and_slab_end_at_one_temperature(slab_s):
    """Without a leak no heat is lost: the plate (capacity 1) and the slab (e sqrt(slab_s)) share what there was."""
    touch = model(0.95, 0.86, slab_s=slab_s, leak_per_s=0.0)
    last = courses(touch, steps=3000)[-1, 0]
    capacity = 0.95 * np.sqrt(slab_s)
    assert last[1] == pytest.approx(1.0 / (1.0 + capacity), abs=0.003)
    assert last[0] + last[1] == pytest.approx(1.0, abs=1e-6)
    assert last[2] == 0.0


def test_without_force_only_the_leak_is_left():
    found = courses(model(7.0, 1.1, lag_s=0.05), force_n=0.0)
    late = TIMES_S > 1.0
    # a slow course is read as it was one lag ago
    wanted = np.exp(-LEAK_PER_S * (TIMES_S[late] - 0.05))
    assert found[late, 0, 1] == pytest.approx(wanted, abs=1e-4)
    assert found[late, 0, 2] == pytest.approx(1.0 - wanted, abs=1e-4)
    assert found[late, 0, 0] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("name", OBJECTS)
def test_slopes_are_finite_differences(name):
    effusivity, conductance = OBJECTS[name]
    h = 1e-3

    def reading(ln_e, ln_h, ln_lag):
        return courses(model(effusivity * np.exp(ln_e), conductance * np.exp(ln_h), LAG_S * np.exp(ln_lag)))[:, 0]

    middle = reading(0.0, 0.0, 0.0)
    for column, axis in enumerate(np.eye(3) * h, start=3):
        more, less = reading(*axis), reading(*-axis)
        # the plate at one kelvin above object and back; what the resistor keeps of its own is no part of the slope
        # for the first two, and for the lag it is: the object's course holds it with its sign turned
        change = -(more[:, 0] - less[:, 0]) - (more[:, 2] - less[:, 2])
        wanted = change / (2.0 * h)
        assert middle[:, column] == pytest.approx(wanted, abs=0.03 * np.abs(wanted).max()), f"column {column}"
        assert np.abs(wanted).max() > 1e-3


def test_force_acts_by_its_share():
    """Half the conductance at the force of half the conductance, whatever the force before."""
    assert SensorConstants(0.04, 0.3).force_share(np.array([0.0, 0.3, -1.0, 2.7])) == pytest.approx([0, 0.5, 0, 0.9])
    half = courses(model(0.95, 0.86), force_n=0.3)
    assert half[:, :, :3] == pytest.approx(courses(model(0.95, 0.43))[:, :, :3], abs=1e-9)


def test_readings_may_come_at_any_rate():
    coarse = courses(model(*OBJECTS["stone"]), steps=200)
    fine = courses(model(*OBJECTS["stone"]), steps=800, dt_s=0.0025)[3::4]
    assert coarse == pytest.approx(fine, abs=3e-3)
    mixed = model(*OBJECTS["stone"])
    for k in range(100):
        mixed.advance((0.015 if k % 2 else 0.005,), np.array([FIRM_N]))
    assert mixed.courses == pytest.approx(fine[99], abs=3e-3)


def test_keep_continues_with_some_as_if_the_others_had_never_existed():
    ln_e, ln_h = np.log([0.2, 0.9, 7.0]), np.log([0.4, 0.8, 1.1])
    slabs = np.array([np.inf, 2.0, 0.5])
    contact_of = np.array([0, 0, 1, 2, 2])
    ln_lag = np.log([0.2, 0.3, 0.3, 0.2, 0.4])
    sensor = SensorConstants(LEAK_PER_S, 0.3)
    many = TouchModel(sensor, Contacts(ln_e, ln_h, slabs), contact_of, ln_lag)
    courses(many, 0.8, steps=50)
    before = many.courses.copy()
    kept = np.array([False, True, False, True, True])
    many.keep(kept)
    assert (many.courses == before[kept]).all()
    few = TouchModel(sensor, Contacts(ln_e[[0, 2]], ln_h[[0, 2]], slabs[[0, 2]]), np.array([0, 1, 1]), ln_lag[kept])
    courses(few, 0.8, steps=50)
    for force_n in (0.8, 1.5):
        assert courses(many, force_n, steps=30) == pytest.approx(courses(few, force_n, steps=30), abs=1e-12)


@pytest.mark.parametrize("early_s", [0.0, 0.03, -0.015])
def test_many_steps_at_once_are_those_steps(early_s):
    steps_s = [0.01] * 30 + [0.02, 0.01, 0.03] + [0.02] * 5
    force_n = np.linspace(0.2, 1.5, len(steps_s))
    contacts = Contacts(np.log([0.2, 7.0]), np.log([0.4, 1.1]), np.array([np.inf, 0.5]))
    sensor = SensorConstants(LEAK_PER_S, 0.3, early_s)
    at_once, one_by_one = (TouchModel(sensor, contacts, np.array([0, 1, 1]), np.log([0.2, 0.3, 0.4])) for _ in "12")
    found = at_once.advance(steps_s, force_n)
    for k, (dt_s, force) in enumerate(zip(steps_s, force_n, strict=True)):
        one_by_one.advance((dt_s,), np.asarray(force)[None])
        courses_now = one_by_one.courses
        assert courses_now == pytest.approx(found[k].T, abs=1e-10)
    assert (at_once.courses == found[-1].T).all()
