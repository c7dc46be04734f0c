"""Hypotheses over the random parameters of a touch together form the calibrated normals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remote_site.thermal.touch_hypotheses import (
    FOREIGN,
    FOREIGN_FROM,
    FOREIGN_LN_STEP,
    FOREIGN_TO,
    SOFTER,
    guesses,
    spread,
    substances,
)
from tests.unit.remote_site.made_touches import MATERIALS, PLATE_J_M2K, true_table


@given(st.floats(0.01, 1.0), st.sampled_from([0.1, 0.2, 0.3]))
def test_a_row_of_narrow_normals_is_the_wide_one(sd, spacing):
    means, weights, inner = spread(sd, spacing)
    assert weights.sum() == pytest.approx(1.0)
    assert weights @ means == pytest.approx(0.0, abs=1e-9)
    assert inner <= sd + 1e-12
    # a normal that is cut off at REACH_SD is narrower by 8.4 %
    assert np.sqrt(weights @ means**2 + inner**2) == pytest.approx(sd, rel=0.09)
    at = np.linspace(-2.0 * sd, 2.0 * sd, 41)
    row = (weights * np.exp(-0.5 * ((at[:, None] - means) / inner) ** 2) / inner).sum(axis=1)
    wide = np.exp(-0.5 * (at / sd) ** 2) / sd
    assert row == pytest.approx(wide, abs=0.12 * wide.max())


def table(covariances):
    made = true_table()
    entries = [
        entry.model_copy(update={"covariance": covariance})
        for entry, covariance in zip(made.materials, covariances, strict=True)
    ]
    return made.model_copy(update={"materials": entries, "ln_lag_sd": 0.3})


COVARIANCES = [
    [[0.05**2, 0.0], [0.0, 0.10**2]],
    [[0.30**2, 0.7 * 0.3 * 0.25], [0.7 * 0.3 * 0.25, 0.25**2]],
    [[0.40**2, -0.5 * 0.4 * 0.3], [-0.5 * 0.4 * 0.3, 0.30**2]],
]


def test_the_guesses_of_a_material_are_its_population():
    made = table(COVARIANCES)
    laid_out = guesses(made)
    ln = np.column_stack(
        (
            laid_out.contacts.ln_effusivity[laid_out.contact_of],
            laid_out.contacts.ln_conductance[laid_out.contact_of],
            laid_out.ln_lag,
        )
    )
    for number, entry in enumerate(made.materials):
        mine = laid_out.substance == number
        weight = np.exp(laid_out.ln_weight[mine])
        assert weight.sum() == pytest.approx(1.0)
        mean = weight @ ln[mine]
        assert mean == pytest.approx([entry.ln_effusivity, entry.ln_conductance, made.ln_lag], abs=1e-6)
        away = ln[mine] - mean
        covariance = np.einsum("n,nij->ij", weight, laid_out.covariance[mine] + away[:, :, None] * away[:, None, :])
        sd = np.sqrt(np.diag(covariance))
        wanted = np.zeros((3, 3))
        wanted[:2, :2], wanted[2, 2] = entry.covariance, made.ln_lag_sd**2
        assert sd == pytest.approx(np.sqrt(np.diag(wanted)), rel=0.09)
        assert covariance / np.outer(sd, sd) == pytest.approx(
            wanted / np.sqrt(np.outer(np.diag(wanted), np.diag(wanted))), abs=0.05
        )


def test_thin_pieces_are_guessed_as_slabs():
    made = true_table()
    thin = made.materials[0].model_copy(update={"slab_s": 0.5})
    laid_out = guesses(made.model_copy(update={"materials": [thin, *made.materials[1:]]}))
    slabs = laid_out.contacts.slab_s[laid_out.contact_of]
    assert set(slabs[laid_out.substance == 0]) == {0.5}
    assert set(slabs[laid_out.substance > 0]) == {np.inf}


def test_every_guess_starts_possible():
    laid_out = guesses(table(COVARIANCES))
    assert np.isfinite(laid_out.ln_weight).all()
    assert (np.linalg.eigvalsh(laid_out.covariance) > 0.0).all()
    assert len({len(laid_out.contact_of), len(laid_out.ln_lag), len(laid_out.substance), len(laid_out.covariance)}) == 1
    assert laid_out.contact_of.max() == len(laid_out.contacts.ln_effusivity) - 1


def test_uncalibrated_substances_are_covered_from_foam_to_copper():
    known = substances(true_table())
    assert known.calibrated == len(MATERIALS)
    assert known.probability.sum() == pytest.approx(1.0)
    assert known.probability[known.calibrated :].sum() == pytest.approx(FOREIGN)
    foreign = known.ln_effusivity[known.calibrated :] + np.log(PLATE_J_M2K)
    assert np.exp(foreign[[0, -1]]) == pytest.approx([FOREIGN_FROM, FOREIGN_TO])
    assert np.diff(foreign) == pytest.approx(FOREIGN_LN_STEP, rel=0.05)
    assert known.effusivity_variance.shape == known.ln_effusivity.shape


def test_materials_are_as_frequent_as_in_their_calibration():
    made = true_table()
    first, *others = made.materials
    twice = first.model_copy(update={"touches": 2 * others[0].touches})
    known = substances(made.model_copy(update={"materials": [twice, *others]}), 0.1)
    share = 0.9 / (len(others) + 2)
    assert known.probability[: known.calibrated] == pytest.approx([2 * share, *[share] * len(others)])


def test_a_foreign_contact_is_guessed_like_that_of_its_neighbours():
    made = true_table()
    laid_out, known = guesses(made), substances(made)
    for number in range(len(made.materials), laid_out.substance.max() + 1):
        mine = laid_out.substance == number
        conductance = np.exp(laid_out.ln_weight[mine]) @ laid_out.contacts.ln_conductance[laid_out.contact_of[mine]]
        usual = [entry.ln_conductance for entry in made.materials]
        assert conductance <= max(usual) + 1e-9
        softer = min(entry.ln_effusivity for entry in made.materials) - known.ln_effusivity[number]
        assert conductance >= min(usual) - SOFTER * max(softer, 0.0) - 1e-9
