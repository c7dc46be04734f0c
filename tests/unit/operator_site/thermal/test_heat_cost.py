"""The cost of a step of heat, as ratios within one run."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from common.limits import COMFORT
from common.scenes.materials import materials
from operator_site.thermal.plates import PlateSetpoint
from operator_site.thermal.scene_skin import SceneSkin
from operator_site.thermal.skin_model import STEP_S, SkinModel, Touched, skin_rates, skin_step
from operator_site.thermal.tissue import Body, rest
from teletaction.session.step_cost import quickest_s

MODEL = SkinModel(4, 1, 1, 6)
FIVE = ("aluminium", "ceramic_tile", "pvc", "pine", "skin_dermis")


def hand(fingers: int) -> tuple[SceneSkin, Callable[[], object]]:
    """Fingers in contact, and one whole step of them: skin and plates."""
    skin = SceneSkin(MODEL, fingers=fingers)
    display = PlateSetpoint(COMFORT, skin.state().surface_c)
    for finger in range(fingers):
        skin.touch(finger, Touched.of(FIVE[finger % 5]), 23.0)
    touching = [True] * fingers

    def step() -> None:
        display.aim(skin.step(), touching)
        display.step(STEP_S)

    return skin, step


def test_a_step_costs_at_most_fifteen_bare_products() -> None:
    a, x = np.random.default_rng(0).standard_normal((5, 12, 12)), np.ones((5, 12, 1))
    _, step = hand(5)
    ratios = [quickest_s(step, 200, 5) / quickest_s(lambda: np.matmul(a, x), 2000, 5) for _ in range(5)]
    assert min(ratios) <= 15.0, ratios


def test_skins_of_fingers_together_cost_less_each() -> None:
    each = [quickest_s(hand(fingers)[0].step, max(1, 500 // fingers), 7) / fingers for fingers in (1, 5, 50, 1000)]
    assert each[0] > 1.5 * each[1] > 3.0 * each[2]
    assert each[3] < each[2]


@pytest.mark.parametrize("name", ["aluminium", "pvc"])
def test_a_general_integrator_costs_ten_times_as_much_for_more_error(name: str) -> None:
    rates, resting = skin_rates(MODEL, Touched.of(name)), rest(Body())
    inputs = np.array([resting.flux_w_m2, 23.0 - resting.surface_c])
    x = np.zeros(12)
    x[6:] = 23.0 - resting.surface_c
    drive = rates.b @ inputs

    def integrate(rtol: float) -> np.ndarray:
        """Ten seconds, a call for each step as a loop has it."""
        state, felt = x, []
        for _ in range(100):
            state = solve_ivp(
                lambda _t, y: rates.a @ y + drive, (0.0, STEP_S), state, method="LSODA", rtol=rtol, atol=1e-6
            ).y[:, -1]
            felt.append(float(rates.c[0] @ state))
        return np.array(felt)

    skin = SceneSkin(MODEL, fingers=1)
    skin.touch(0, Touched.of(name), 23.0)
    exact = np.array([skin.step().epidermis_c[0] for _ in range(100)]) - resting.layers_c[0]
    tight = integrate(1e-10)
    assert np.abs(exact - tight).max() <= np.abs(integrate(1e-4) - tight).max() + 1e-6
    assert quickest_s(lambda: integrate(1e-4), 1, 3) / 100 > 10.0 * quickest_s(skin.step, 100, 5)


def test_a_change_of_contact_costs_little_beside_its_matrix_exponentials() -> None:
    """Five new objects at once are five exponentials: 0.3 ms on a quiet machine, of the 10 ms of a step."""
    skin, _ = hand(5)
    names = iter(sorted(materials()) * 3)
    rates = skin_rates(MODEL, Touched.of("iron"))
    block = STEP_S * np.block([[rates.a, rates.b], [np.zeros((2, 14))]])

    def change() -> None:
        skin_step.cache_clear()
        for finger in range(5):
            skin.touch(finger, Touched.of(next(names)), 20.0)

    ratios = [quickest_s(change, 1, 6) / (5.0 * quickest_s(partial(expm, block), 5, 6)) for _ in range(3)]
    assert min(ratios) <= 4.0, ratios
