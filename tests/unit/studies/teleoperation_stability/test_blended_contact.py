"""The baseline of stability: a local contact that blends its models."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import FINGER_FORCE_N, FORCE_RAMP_DOWN_N_S, FORCE_RAMP_UP_N_S
from studies.teleoperation_stability.blended_contact import STIFFEST_N_M, BlendedContact

DT = 0.002


def settled(z_m: float, surface_m: float = 0.0, stiffness: float = 300.0) -> float:
    contact = BlendedContact()
    return [contact.step(i * DT, z_m, surface_m, stiffness) for i in range(600)][-1]


def test_law_is_unilateral_capped_and_local():
    assert settled(0.001) == 0.0
    assert settled(-0.002) == pytest.approx(0.6)
    assert settled(-0.002, stiffness=5000.0) == pytest.approx(0.002 * STIFFEST_N_M)
    assert settled(-0.002, stiffness=0.0) == 0.0
    assert settled(-0.001, surface_m=0.001) == pytest.approx(0.6)
    assert settled(-0.2) == FINGER_FORCE_N


def test_damping_resists_approach_and_never_pulls():
    contact = BlendedContact()
    for i in range(100):
        contact.step(i * DT, 0.001, 0.0, 100.0, 2.0)
    assert contact.step(100 * DT, -0.01, 0.0, 100.0, 2.0, 0.05) == pytest.approx(1.0 + 2.0 * 0.05)
    assert contact.step(101 * DT, -0.01, 0.0, 100.0, 2.0, -5.0) == 0.0


@given(
    st.lists(st.tuples(st.floats(-0.01, 0.01), st.floats(0.0, 2000.0)), min_size=2, max_size=10),
    st.floats(-0.01, 0.01),
)
def test_model_updates_do_not_jump(models, z_m):
    contact, before, t_s = BlendedContact(), 0.0, 0.0
    for surface_m, stiffness in models:
        for _ in range(20):
            t_s += DT
            force = contact.step(t_s, z_m, surface_m, stiffness)
            assert force - before <= FORCE_RAMP_UP_N_S * DT + 1e-9
            assert before - force <= FORCE_RAMP_DOWN_N_S * DT + 1e-9
            before = force


def test_stable_on_a_finger_with_the_loops_own_delay():
    """0.1 kg, 3 Ns/m, 400 N/m hand spring, forces 5 ms late: an oscillation must die."""
    contact, z_m, v_m_s, queue, heights = BlendedContact(), 0.004, 0.0, [0.0] * 3, []
    for i in range(2000):
        queue.append(contact.step(i * DT, round(z_m / 5e-6) * 5e-6, 0.0, 5000.0))
        force = queue[-4]
        for _ in range(4):
            v_m_s += DT / 4 * (force + 400.0 * (-0.004 - z_m) - 3.0 * v_m_s) / 0.1
            z_m += DT / 4 * v_m_s
        heights.append(z_m)
    assert np.ptp(heights[-200:]) < 1e-4
    assert heights[-1] == pytest.approx(-0.002, abs=1e-4)
