"""The study of thermal identification: its baselines exactly, its counts, its bound, and a run of tiny sizes."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from remote_site.thermal.thermal_identification import ThermalIdentification
from sim_sensors.physics.ssr_converter import NOISE_C
from studies.thermal_identification.answers import Answered, by_fingers, by_product, knowledge_of
from studies.thermal_identification.bound import bounds, reading_noise_k
from studies.thermal_identification.exponential import WAYS, LaggedResponse, fits
from studies.thermal_identification.figure import plot
from studies.thermal_identification.maps import Axes, foreign_materials
from studies.thermal_identification.pieces import Calibration, calibrate
from studies.thermal_identification.reference import BLOCKS, features, train
from studies.thermal_identification.run import QUICK, measure, tables
from studies.thermal_identification.shares import errors, reliability, shares
from studies.thermal_identification.situations import FOUR, STAGGERED_K, Hand, Situation, noisier, touched
from tests.unit.studies.written import draw_figure

TIMES_S = (0.5, 1.0)
SHORT_S = (0.25, 0.5)
TINY = replace(
    QUICK,
    calibration=8,
    learning=(12, 0, 0),
    test=(2, 0),
    hands=(1, 0),
    times_s=SHORT_S,
    hand_times_s=SHORT_S[:1],
    reference_times_s=SHORT_S[:1],
    maps=Axes((10.0,), (NOISE_C,), ((0.2, 0.0),), (0.15,), foreign=1, touches=1, times_s=SHORT_S, seconds=0.55),
    cost_touches=4,
    cost_calibration=8,
    cost_materials=(2, 4),
    cost_s=0.22,
    seconds=0.55,
    calibration_s=2.05,
)


@pytest.fixture(scope="module")
def calibration() -> Calibration:
    return calibrate(FOUR, 6, 1, NOISE_C, 1.55, (0.5, 1.0, 1.5))


@pytest.fixture(scope="module")
def hands() -> list[Hand]:
    return [hand for name in ("aluminium", "pine") for hand in touched(Situation(name, 9, 2, seconds=1.55))]


@pytest.mark.parametrize(("tau_s", "lag_s", "offset_k"), [(1.3, 0.3, 8.0), (6.0, 0.2, -5.0), (0.5, 0.5, 10.0)])
def test_the_good_fit_finds_an_exponential_read_with_lag(tau_s: float, lag_s: float, offset_k: float) -> None:
    object_c = 21.0
    response = LaggedResponse(object_c + offset_k)
    # the lag of a plate that falls exponentially, step by step: no formula that the fit could share
    read_k, step_s = offset_k, 1e-4
    for k in range(1, 30_001):
        plate_k = offset_k * np.exp(-(k - 0.5) * step_s / tau_s)
        read_k += (plate_k - read_k) * (1.0 - np.exp(-step_s / lag_s))
        if k % 100 == 0:
            response.add(k * step_s, object_c + float(read_k))
    fit = response.fit()
    assert fit is not None
    assert fit.object_c == pytest.approx(object_c, abs=0.15 * abs(offset_k))
    assert np.log(fit.rate_per_s * tau_s) == pytest.approx(0.0, abs=0.2)
    assert fit.residual_k < 0.05


@pytest.mark.long
def test_the_papers_way_is_the_products(calibration: Calibration, hands: list[Hand]) -> None:
    knowledge = knowledge_of(calibration.table)
    rates = calibration.rates[list(WAYS).index("paper")]
    late = len(rates.times_s) - 1
    assert rates.ln_rate[:, late] == pytest.approx([entry.ln_rate[late] for entry in knowledge.table.materials])
    for hand in hands:
        touch, fitted_s, before = hand.fingers[0], 0.0, None
        product = ThermalIdentification(knowledge)
        product.start(0.0, touch.start_c, touch.slope_k_s, touch.ambient_c)
        for since_s, sensor_c, force_n in list(touch.readings())[1:]:
            if since_s > rates.times_s[late] + 1e-6:
                break
            if (answer := product.step(since_s, sensor_c, force_n)).exponential_object_c != before:
                fitted_s, before = since_s, answer.exponential_object_c
        early, fit = fits("paper", touch, (rates.times_s[0], fitted_s))
        assert early is None, "nothing is fitted before the lag is over"
        assert fit is not None
        assert fitted_s > rates.times_s[late] - 0.1, "it is fitted again and again"
        assert product.answer.exponential_object_c == pytest.approx(fit.object_c)
        assert product.answer.exponential_material == rates.likeliest(late, fit)


@pytest.mark.long
def test_drawing_answers_less_often_changes_none_of_them(calibration: Calibration, hands: list[Hand]) -> None:
    knowledge = knowledge_of(calibration.table)
    for hand in hands:
        seldom = by_fingers(knowledge, hand, {"one": 1}, TIMES_S)
        often = by_product(knowledge, "one", hand, TIMES_S)
        assert [(a.best, a.t_s) for a in seldom] == [(a.best, a.t_s) for a in often]
        assert [a.probability for a in seldom] == pytest.approx([a.probability for a in often], abs=1e-6)
        assert [a.error_k for a in seldom] == pytest.approx([a.error_k for a in often], abs=1e-6)


def test_answers_are_counted() -> None:
    answers = [
        Answered("m", "pine", 1.0, "pine", 0.998, "identified", 0.3, 0.2, 0.4),
        Answered("m", "pine", 1.0, "pvc", 0.995, "identified", -0.4, 0.2, 0.8),
        Answered("m", "pvc", 1.0, "pvc", 0.6, "deciding"),
        Answered("m", "pvc", 1.0, "pine", 0.4, "unknown"),
        Answered("m", "pvc", 2.0, None),
    ]
    first, second = shares(answers, materials=2)
    assert (first["right"], first["identified"], first["wrong"]) == (0.5, 0.5, 0.25)
    assert sum(first[kind] for kind in ("identified", "ambiguous", "deciding", "unknown", "unidentifiable")) == 1.0
    assert first["object_rms_k"] == pytest.approx(np.sqrt((0.09 + 0.16) / 2), abs=1e-3)
    assert (first["named_s"], first["object_within_sd"], first["object_errors"]) == (0.6, 0.5, 2)
    assert second["right"] is None, "a method that cannot say anything yet is not wrong"
    assert errors(answers) == [{"method": "m", "t_s": 1.0, "material": "pine", "named": "pvc", "touches": 1}]
    sure = reliability(answers)[-1]
    assert (sure["from"], sure["answers"], sure["right"]) == (0.99, 2, 0.5)


def test_strangers_count_as_often_as_the_prior_expects_them() -> None:
    known = [Answered("m", "pine", 1.0, "pine", 0.92)] * 90 + [Answered("m", "pine", 1.0, "pvc", 0.92)] * 10
    strange = [Answered("m", "glass", 1.0, "pine", 0.94)] + [Answered("m", "glass", 1.0, "pine", 0.1)] * 4
    (low, sure) = reliability(known, strange, 0.2)
    # 5 strangers stand for 25 among 125 touches, and 5 of these are taken for pine
    assert (low["right"], sure["answers"]) == (0.0, 101)
    assert sure["right"] == pytest.approx(90.0 / 105.0, abs=1e-4)
    assert sure["claimed"] == pytest.approx((100 * 0.92 + 5 * 0.94) / 105.0, abs=1e-4)


@pytest.mark.long
def test_the_bound_falls_with_time_and_fingers_and_staggered_plates_tell_the_temperature() -> None:
    found = {(row["fingers"], row["t_s"]): row for row in bounds("pine", STAGGERED_K[:2], TIMES_S)}
    equal = {(row["fingers"], row["t_s"]): row for row in bounds("pine", (10.0, 10.0), TIMES_S)}
    assert found[1, 1.0]["object_sd_k"] < found[1, 0.5]["object_sd_k"]
    assert equal[2, 0.5]["object_sd_k"] < equal[1, 0.5]["object_sd_k"]
    assert found[2, 0.5]["object_sd_k"] < equal[2, 0.5]["object_sd_k"]
    assert found[1, 0.5]["object_sd_k"] < 6.0 / np.sqrt(12.0), "less than the prior"
    assert reading_noise_k() > NOISE_C


@pytest.mark.long
def test_noise_is_added_up_to_the_wanted_one(hands: list[Hand]) -> None:
    assert noisier(hands, NOISE_C, 1) == hands
    before, after = hands[0].fingers[0].trace.sensor_c, noisier(hands, 0.2, 1)[0].fingers[0].trace.sensor_c
    assert np.std(after - before) == pytest.approx(np.sqrt(0.2**2 - NOISE_C**2), rel=0.15)


def made_rows(touches: int, fingers: int, seed: int) -> tuple[np.ndarray, list[str], np.ndarray]:
    """Return features of made-up touches, whose falls are in proportion to the difference from the object."""
    chance = np.random.default_rng(seed)
    materials = [("pine", "pvc")[k % 2] for k in range(touches)]
    above_k = chance.uniform(-3.0, 3.0, touches)
    plate_k = np.array((10.0, 6.0, 3.0)[:fingers]) + 0.05 * chance.standard_normal((touches, fingers))
    time = np.linspace(0.1, 1.0, BLOCKS)
    early = np.where(np.array(materials) == "pine", 1.0, 1.6)[:, None, None]
    contact = np.exp(0.2 * chance.standard_normal((touches, fingers)) + 0.1 * chance.standard_normal((touches, 1)))
    response = 0.3 * contact[..., None] * time**early
    fallen_k = (plate_k - above_k[:, None])[..., None] * response + 0.01 * chance.standard_normal(response.shape)
    beside = np.stack((plate_k, *(0.01 * chance.standard_normal((3, touches, fingers)))), axis=-1)
    return np.concatenate((fallen_k, beside), axis=-1), materials, above_k


@pytest.mark.long
@pytest.mark.parametrize("fingers", [1, 3])
def test_the_reference_learns_what_is_there_and_knows_how_well(fingers: int) -> None:
    reference = train(*made_rows(200, fingers, 1))
    rows, materials, above_k = made_rows(200, fingers, 2)
    probability, found_k, sd_k = reference.judge(rows)
    names = [reference.names[k] for k in probability.argmax(axis=1)]
    assert np.mean([name == true for name, true in zip(names, materials, strict=True)]) > 0.95
    assert probability.sum(axis=1) == pytest.approx(1.0)
    assert np.mean(np.abs(found_k - above_k) < 1.96 * sd_k) == pytest.approx(0.95, abs=0.08)
    if fingers > 1:
        assert np.median(np.abs(found_k - above_k)) < 0.5, "staggered plates show the temperature"


def test_features_hold_nothing_of_later_readings(hands: list[Hand]) -> None:
    finger = hands[0].fingers[0]
    sensor_c = finger.trace.sensor_c.copy()
    sensor_c[finger.first + 51 :] += 5.0
    later = replace(hands[0], fingers=(replace(finger, trace=replace(finger.trace, sensor_c=sensor_c)),))
    assert np.array_equal(features([later], 1, 0.5), features(hands[:1], 1, 0.5))
    assert not np.array_equal(features([later], 1, 0.6), features(hands[:1], 1, 0.6))


def test_foreign_materials_span_from_the_nearest_to_the_farthest() -> None:
    away = [abs(ln) for _, ln in foreign_materials(replace(TINY.maps, foreign=5))]
    assert len(away) == 5
    assert away == sorted(away)
    assert away[0] < 0.2
    assert away[-1] > 1.0


@pytest.mark.long
@pytest.mark.timeout(240)  # some ten seconds, but on a machine that is busy with something else
def test_a_tiny_run_has_all_parts(tmp_path: Path) -> None:
    progress: list[float] = []
    data = measure(TINY, 0, progress.append)
    assert progress == sorted(progress)
    assert progress[-1] == 1.0
    assert json.loads(json.dumps(data)) == data
    methods = {row["method"] for row in data["accuracy"]}
    assert methods >= {"paper", "good exponential", "1 finger", "2 equal", "5 staggered", "reference"}
    for name, rows in tables(data).items():
        assert rows or name == "errors", name
        assert len({tuple(row) for row in rows}) <= 1, f"{name}: rows of one table have the same columns"
    assert [row["materials"] for row in data["cost_by_materials"]] == [2, 4]
    guesses = [row["guesses"] for row in data["cost_by_materials"]]
    assert guesses[0] < guesses[1]
    draw_figure(plot, data, tmp_path, 50_000)
