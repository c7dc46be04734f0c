"""Correction of evidence by a known discrepancy."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from remote_site.thermal.discrepancy import Discrepancy
from remote_site.thermal.evidence_correction import BEYOND, EvidenceCorrection
from remote_site.thermal.touch_estimate import TouchEvidence

LN_EFFUSIVITY = np.array([0.0, -2.0, -1.0])
"""Two calibrated materials, and another substance halfway between them."""
AMBIENT_C, PLATE_K = 23.0, 10.0
KNOWN = Discrepancy(
    times_s=[1.0, 3.0],
    plate_k=[PLATE_K, PLATE_K],
    coldest_k=[-2.0, -4.0],
    warmest_k=[4.0, 2.0],
    by_plate=[[0.02, -0.04], [0.04, 0.0]],
    by_object=[[0.1, -0.1], [0.0, 0.0]],
    by_object_sd=[[0.0, 0.0], [0.1, 0.3]],
    spread=[[0.0, 0.0], [0.05, 0.05]],
    stated_sd=[0.5, 2.0],
    sharpness=[0.5, 1.0],
    known_objects=[True, True],
)
OBJECT_K = np.array([2.0, -3.0, 1.0])


def evidence(by_plate: NDArray[np.float64], by_object: NDArray[np.float64], plate_k: float = PLATE_K) -> TouchEvidence:
    """Evidence of an object at OBJECT_K under each substance, with these errors."""
    mean = np.stack((OBJECT_K + by_plate * plate_k + by_object * OBJECT_K, LN_EFFUSIVITY), axis=1)
    covariance = np.tile([[0.04, 0.01], [0.01, 0.02]], (3, 1, 1))
    return TouchEvidence(np.array([-1.0, -2.0, -4.0]), mean, covariance, AMBIENT_C, AMBIENT_C + plate_k, 1.0)


@pytest.mark.parametrize(
    ("since_s", "by_plate", "by_object"),
    [
        (0.2, [0.02, -0.04, -0.01], [0.1, -0.1, 0.0]),
        (1.0, [0.02, -0.04, -0.01], [0.1, -0.1, 0.0]),
        (2.0, [0.03, -0.02, 0.005], [0.05, -0.05, 0.0]),
        (9.0, [0.04, 0.0, 0.02], [0.0, 0.0, 0.0]),
    ],
)
def test_the_errors_are_taken_out_at_each_time(since_s: float, by_plate: list[float], by_object: list[float]) -> None:
    found = EvidenceCorrection(KNOWN, LN_EFFUSIVITY).corrected(
        evidence(np.array(by_plate), np.array(by_object)), since_s
    )
    assert found.mean[:, 0] == pytest.approx(OBJECT_K)
    assert found.mean[:, 1] == pytest.approx(LN_EFFUSIVITY)


def test_variances_and_likelihoods_are_scaled() -> None:
    plain = evidence(np.zeros(3), np.zeros(3))
    early = EvidenceCorrection(KNOWN, LN_EFFUSIVITY).corrected(plain, 1.0)
    scale = 0.5 / np.array([1.1, 0.9, 1.0])
    assert early.covariance[:, 0, 0] == pytest.approx(0.04 * scale**2)
    assert early.covariance[:, 0, 1] == pytest.approx(0.01 * scale)
    assert early.covariance[:, 1, 1] == pytest.approx(0.02)
    assert early.ln_likelihood == pytest.approx(0.5 * plain.ln_likelihood)


def test_the_spread_grows_with_the_difference_of_plate_and_object() -> None:
    late = EvidenceCorrection(KNOWN, LN_EFFUSIVITY).corrected(evidence(np.array([0.04, 0.0, 0.02]), np.zeros(3)), 3.0)
    assert late.covariance[:, 0, 0] == pytest.approx(4.0 * 0.04 + (0.05 * (PLATE_K - OBJECT_K)) ** 2)


def test_the_spread_of_unknown_objects_is_common_to_all_touches() -> None:
    unknown = KNOWN.model_copy(update={"known_objects": [False, True]})
    late = EvidenceCorrection(unknown, LN_EFFUSIVITY).corrected(evidence(np.array([0.04, 0.0, 0.02]), np.zeros(3)), 3.0)
    spread_k2 = (0.05 * (PLATE_K - OBJECT_K)) ** 2
    # the third substance lies halfway between the calibrated ones, and has half of the spread of either kind
    from_middle_k2 = (np.array([0.1, 0.3, 0.2]) * (OBJECT_K - [1.0, -1.0, 0.0])) ** 2
    assert late.common_k2 == pytest.approx(spread_k2 * [1.0, 0.0, 0.25] + from_middle_k2)
    assert late.covariance[:, 0, 0] == pytest.approx(4.0 * 0.04 + spread_k2 * [0.0, 1.0, 0.25])


def test_a_plate_unlike_that_of_calibration_makes_the_temperature_less_certain() -> None:
    by_plate = np.array([0.04, 0.0, 0.02])
    correction = EvidenceCorrection(KNOWN, LN_EFFUSIVITY)
    same, less = (correction.corrected(evidence(by_plate, np.zeros(3), plate_k), 3.0) for plate_k in (10.0, 4.0))
    grows = 0.05**2 * ((10.0 - OBJECT_K) ** 2 - (4.0 - OBJECT_K) ** 2)
    assert less.covariance[:, 0, 0] == pytest.approx(same.covariance[:, 0, 0] - grows + (6.0 * by_plate) ** 2)


@pytest.mark.parametrize("warmer_k", [-10.0, 10.0])
def test_an_object_unlike_those_of_calibration_makes_the_temperature_less_certain(warmer_k: float) -> None:
    plain = evidence(np.array([0.04, 0.0, 0.02]), np.zeros(3))
    far_k = OBJECT_K + warmer_k
    far = replace(plain, mean=plain.mean + np.array([warmer_k, 0.0]))
    found = EvidenceCorrection(KNOWN, LN_EFFUSIVITY).corrected(far, 3.0)
    assert found.mean[:, 0] == pytest.approx(far_k)
    from_middle_k, beyond_k = far_k - [1.0, -1.0, 0.0], np.abs(far_k - [1.0, -1.0, 0.0]) - 3.0
    assert found.common_k2 == pytest.approx(([0.1, 0.3, 0.2] * from_middle_k) ** 2 + (BEYOND * beyond_k) ** 2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"times_s": [3.0, 1.0]}, "ascend"),
        ({"sharpness": [1.0]}, "one value per time"),
        ({"by_plate": [[0.0], [0.0, 0.0]]}, "one value per material"),
        ({"known_objects": [True]}, "one value per material"),
        ({"warmest_k": [4.0]}, "one value per material"),
        ({"by_object": [[0.0, -1.0], [0.0, 0.0]]}, "greater than -1"),
    ],
)
def test_lists_that_do_not_fit_together_are_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Discrepancy.model_validate({**KNOWN.model_dump(), **change})
