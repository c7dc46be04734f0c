"""The discrepancy that is learned from evidence with known errors."""

import numpy as np
import pytest

from remote_site.thermal.calibration.discrepancy_fit import OBJECT_SD, UNKNOWN_SPREAD, Labelled, Seen, courses, learn
from remote_site.thermal.calibration.temperature_calibration import learn_temperature
from remote_site.thermal.calibration.thermal_calibration import touch_of
from remote_site.thermal.thermal_identification import ThermalKnowledge
from remote_site.thermal.touch_estimate import ANYWHERE_K, TouchEvidence
from remote_site.traces.trace_files import ThermalTrace
from tests.unit.remote_site.made_touches import AMBIENT_C, MATERIALS, made_touches, true_table

TABLE = true_table({name: MATERIALS[name] for name in ("metal", "plastic")})
BY_PLATE, BY_OBJECT = (0.01, -0.03), (0.0, 0.12)
STATED_K = 0.1


def seen(seed: int, count: int, noise: float = 1.0, spread: float = 0.0, belief: float = 1.0) -> list[Seen]:
    """Evidence of both materials with these errors.

    Args:
        seed: seed of objects, plates and noise.
        count: touches of each material.
        noise: true over stated standard deviation of the temperature.
        spread: further error per kelvin between plate and object.
        belief: multiple of the ln likelihood that the model states.
    """
    rng = np.random.default_rng(seed)
    known = ThermalKnowledge.of(TABLE).substances
    found = []
    for material in range(2):
        for _ in range(count):
            object_k, plate_k = rng.uniform(-3.0, 3.0), 10.0 + rng.normal(0.0, 1.0)
            error_k = BY_PLATE[material] * plate_k + BY_OBJECT[material] * object_k
            error_k += noise * STATED_K * rng.normal() + spread * (plate_k - object_k) * rng.normal()
            mean = np.stack((np.full(len(known.probability), object_k + error_k), known.ln_effusivity), axis=1)
            covariance = np.zeros((len(mean), 2, 2))
            covariance[:, 0, 0], covariance[:, 1, 1] = STATED_K**2, 0.9 * known.effusivity_variance
            covariance[known.calibrated :, 0, 0] = ANYWHERE_K**2
            ln_likelihood = np.full(len(mean), -60.0)
            # the ln odds of two normal densities, one at each material
            odds = 3.0 * (rng.normal() + 1.5)
            ln_likelihood[material], ln_likelihood[1 - material] = 0.0, -belief * odds
            touch = TouchEvidence(ln_likelihood, mean, covariance, AMBIENT_C, AMBIENT_C + plate_k, 1.0)
            found.append(Seen(touch, material, AMBIENT_C + object_k))
    return found


@pytest.mark.long
@pytest.mark.parametrize(("noise", "spread"), [(0.5, 0.0), (1.0, 0.05)])
def test_errors_and_their_variance_are_learned(noise: float, spread: float) -> None:
    found = learn(TABLE, {1.0: seen(1, 150, noise, spread), 2.0: seen(2, 150, noise, spread)})
    assert found.times_s == [1.0, 2.0]
    assert found.known_objects == [True, True]
    for number in range(2):
        assert found.by_plate[number] == pytest.approx(BY_PLATE, abs=0.005 + 0.2 * spread)
        assert found.by_object[number] == pytest.approx(BY_OBJECT, abs=0.03 + 0.8 * spread)
        whole_k = np.hypot(found.stated_sd[number] * STATED_K, 10.0 * np.array(found.spread[number]))
        assert whole_k == pytest.approx(np.hypot(noise * STATED_K, 10.0 * spread), rel=0.15)


@pytest.mark.long
def test_a_model_that_believes_too_much_gets_a_smaller_exponent() -> None:
    right, eager = (learn(TABLE, {1.0: seen(3, 150, belief=belief)}).sharpness[0] for belief in (1.0, 4.0))
    assert 0.6 < right < 1.5
    assert eager == pytest.approx(right / 4.0, rel=0.2)


def test_objects_of_unknown_temperature_teach_nothing_about_it() -> None:
    touches = [one if one.material == 0 else Seen(one.evidence, 1, None) for one in seen(4, 40)]
    found = learn(TABLE, {1.0: touches})
    assert found.known_objects == [True, False]
    assert found.by_plate[0][0] == pytest.approx(BY_PLATE[0], abs=0.01)
    assert (found.by_plate[0][1], found.by_object[0][1]) == (0.0, 0.0)
    assert found.spread[0][1] == UNKNOWN_SPREAD
    assert found.by_object_sd[0][1] == OBJECT_SD
    assert (found.coldest_k[1], found.warmest_k[1]) == (0.0, 0.0)


def test_the_error_of_warmer_objects_is_known_as_well_as_stated() -> None:
    """Objects within 3 K of ambient show the error by object only so well; 40 calibrations show how well."""
    off = []
    for seed in range(40):
        found = learn(TABLE, {1.0: seen(100 + seed, 25)})
        assert -3.0 <= found.coldest_k[0] < 0.0 < found.warmest_k[0] <= 3.0
        off += ((np.array(found.by_object[0]) - BY_OBJECT) / found.by_object_sd[0]).tolist()
    assert 0.7 < np.std(off) < 1.3


def test_a_material_without_evidence_is_not_known() -> None:
    found = learn(TABLE, {1.0: [one for one in seen(4, 10) if one.material == 0]})
    assert found.known_objects == [True, False]
    assert found.spread[0][1] == UNKNOWN_SPREAD


def lifted(seconds: float, count: int = 1) -> list[ThermalTrace]:
    """Traces of touches whose finger leaves the object after some seconds."""
    return [
        ThermalTrace(one.time_s, one.sensor_c, np.where(one.time_s < seconds, one.force_n, 0.0), name=f"{seconds} s")
        for one in made_touches("plastic", count, 5, 1.5)
    ]


def test_touches_that_are_too_short_to_teach_anything_are_refused() -> None:
    (trace,) = lifted(0.1)
    with pytest.raises(ValueError, match=r"no touch lasts 0.3 s: contact is lost, or readings are missing or stuck"):
        courses(TABLE, [Labelled(touch_of(trace), 1, AMBIENT_C)], map)


def test_a_reference_that_the_finger_leaves_early_is_refused() -> None:
    table = TABLE.model_copy(update={"discrepancy": learn(TABLE, {0.5: seen(5, 10), 1.0: seen(6, 10)})})
    touches = [("plastic", trace, AMBIENT_C) for trace in [*lifted(1.5, 4), *lifted(0.7)]]
    with pytest.raises(ValueError, match=r"0\.7 s: the touch ends before 1\.00 s: contact is lost"):
        learn_temperature(table, touches)
