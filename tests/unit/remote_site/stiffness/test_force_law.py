"""The law of a press is convex, and its derivatives are those of its force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remote_site.stiffness.force_law import PARAMETERS, depth_at, force, gradient

LAWS = st.tuples(
    st.floats(-3.0, 2.0), st.floats(-4.0, 1.0), st.floats(-4.0, 1.0), st.floats(-0.3, 0.3), st.floats(-0.1, 0.1)
).map(lambda row: np.array([row]))
DEPTHS = np.linspace(0.4, 2.0, 9)[np.newaxis]


@given(LAWS)
def test_each_tangent_is_a_lower_bound(law: np.ndarray) -> None:
    force_n, _, slope = gradient(law, DEPTHS)
    tangents = force_n[0, :, np.newaxis] + slope[0, :, np.newaxis] * (DEPTHS - DEPTHS.T)
    assert np.all(tangents <= force(law, DEPTHS) * (1.0 + 1e-9) + 1e-9)


@given(LAWS)
def test_derivatives(law: np.ndarray) -> None:
    _, by_parameters, by_depth = gradient(law, DEPTHS)
    for k in range(PARAMETERS):
        step = 1e-6 * np.eye(PARAMETERS)[k]
        change = (force(law + step, DEPTHS) - force(law - step, DEPTHS)) / 2e-6
        assert by_parameters[..., k] == pytest.approx(change, rel=1e-4, abs=1e-4 * (1.0 + np.abs(change).max()))
    change = (force(law, DEPTHS + 1e-6) - force(law, DEPTHS - 1e-6)) / 2e-6
    assert by_depth == pytest.approx(change, rel=1e-4, abs=1e-6)


@given(LAWS, st.floats(0.01, 10.0))
def test_depth_of_a_force(law: np.ndarray, newton: float) -> None:
    u, exponent = depth_at(law, newton)
    force_n, _, slope = gradient(law, u[:, np.newaxis] + law[:, 3:4])
    assert force_n[0] - law[0, 4] == pytest.approx(newton, rel=1e-6)
    assert slope[0] * u == pytest.approx(exponent * newton, rel=1e-6)


def test_above_the_contact_there_is_only_the_offset() -> None:
    law = np.array([[0.0, -1.0, -1.0, 0.2, 0.03]])
    assert force(law, np.array([[-5.0, 0.0, 0.2]])) == pytest.approx(0.03)
