"""The heat network against closed forms: a cooling node, a half space under a contact, and conserved energy."""

import numpy as np
import pytest
from scipy.special import erfcx

from studies.second_world.axisymmetric import grown
from studies.second_world.heat_network import Network, Stepper


def test_a_node_cools_exponentially() -> None:
    network = Network()
    network.node(2.0, ambient_w_k=1.0)
    stepper = Stepper(network, (), 0.005)
    stepper.settle(np.array([10.0]))
    course = [float(stepper.step(np.zeros(0), np.zeros(1))[0]) for _ in range(800)]
    expected = 10.0 * np.exp(-0.5 * 0.005 * np.arange(1, 801))
    np.testing.assert_allclose(course, expected, atol=2e-3)


def test_energy_is_conserved_through_a_changing_contact() -> None:
    network = Network()
    warm, cold = network.node(1.0), network.node(3.0)
    stepper = Stepper(network, [(warm, cold)], 0.01)
    stepper.settle(np.array([8.0, 0.0]))
    for step in range(2000):
        stepper.step(np.array([0.0 if step < 10 else 0.5]), np.zeros(2))
    np.testing.assert_allclose(stepper.above_k, [2.0, 2.0], atol=1e-3)


@pytest.mark.parametrize("conductivity_w_mk", [0.17, 1.3, 15.0])
def test_a_half_space_under_a_contact(conductivity_w_mk: float) -> None:
    """The surface of a half space below a plate of constant temperature (Carslaw & Jaeger, section 2.7)."""
    heat_j_m3k, contact_w_m2k, step_s = 2.0e6, 1000.0, 0.005
    layers_m = grown(25e-6, 0.06, 28)
    network = Network()
    plate = network.node(1e9)
    cells = [network.node(heat_j_m3k * float(thick_m)) for thick_m in layers_m]
    for k in range(len(cells) - 1):
        network.link(cells[k], cells[k + 1], 2.0 * conductivity_w_mk / float(layers_m[k] + layers_m[k + 1]))
    stepper = Stepper(network, [(plate, cells[0])], step_s)
    stepper.settle(np.array([10.0] + [0.0] * len(cells)))
    half_cell_w_m2k = 2.0 * conductivity_w_mk / float(layers_m[0])
    series_w_m2k = 1.0 / (1.0 / contact_w_m2k + 1.0 / half_cell_w_m2k)
    for step in range(1, 401):
        above_k = stepper.step(np.array([series_w_m2k]), np.zeros(len(cells) + 1))
        if step in (20, 100, 400):
            flux_w_m2 = series_w_m2k * (above_k[0] - above_k[1])
            surface_k = above_k[0] - flux_w_m2 / contact_w_m2k
            ratio = contact_w_m2k * np.sqrt(step * step_s / (conductivity_w_mk * heat_j_m3k))
            assert surface_k == pytest.approx(10.0 * (1.0 - erfcx(ratio)), abs=0.06)
