"""Stiffness of recorded presses: values within their stated deviations, and no answer without a reason."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from remote_site.stiffness.recorded.identify_stiffness import identify_presses, identify_stiffness
from remote_site.traces.press_files import Contact, Press
from tests.presses import spring_presses, write_presses

TRUE_N_M = 500.0


def values(answers, key):
    return np.array([answer[key] for answer in answers], dtype=float)


@pytest.mark.parametrize("exponent", [1.0, 1.4, 2.2, 3.0])
def test_stiffness_and_exponent_are_found(exponent):
    presses = spring_presses(40, exponent=exponent, spread=0.0, stiffness_n_m=TRUE_N_M, seed=1)
    answers = identify_presses(presses)
    assert np.mean([answer["status"] == "known" for answer in answers]) > 0.5
    assert np.median(values(answers, "stiffness_n_m")) == pytest.approx(TRUE_N_M, rel=0.08)
    off = (values(answers, "exponent") - exponent) / values(answers, "exponent_sd")
    assert np.mean(np.abs(off) < 2.5) > 0.9
    assert values(answers, "exponent") == pytest.approx(exponent, rel=0.12)
    assert np.median(values(answers, "misfit")) == pytest.approx(0.9, abs=0.25)


@pytest.mark.long
@pytest.mark.parametrize("exponent", [1.2, 2.0])
def test_repeated_presses_differ_by_what_the_deviation_says(exponent):
    answers = [identify_presses(spring_presses(60, exponent=exponent, seed=2, noise_n=0.03))]
    same = spring_presses(60, exponent=exponent, seed=2, noise_n=0.0)
    random = np.random.default_rng(9)
    answers.append(
        identify_presses([replace(p, force_n=p.force_n + 0.03 * random.standard_normal(len(p.force_n))) for p in same])
    )
    first, second = (np.log(values(each, "stiffness_n_m")) for each in answers)
    sds = [values(each, "stiffness_sd_n_m") / values(each, "stiffness_n_m") for each in answers]
    outside = np.mean(np.abs(first - second) > 2.0 * np.hypot(*sds))
    assert outside < 0.13


def test_steps_without_times_and_steps_a_second_apart_are_the_same():
    presses = spring_presses(5, exponent=1.5)
    timed = [replace(press, time_s=1.5 * np.arange(len(press.depth_mm))) for press in presses]
    assert identify_presses(timed) == identify_presses(presses)


def test_order_does_not_matter():
    presses = spring_presses(6, exponent=1.5)
    forward, backward = identify_presses(presses), identify_presses(presses[::-1])[::-1]
    assert values(backward, "stiffness_n_m") == pytest.approx(values(forward, "stiffness_n_m"), rel=1e-4)


def test_other_places_give_the_exponent_of_a_short_press():
    deep = spring_presses(30, exponent=2.5, spread=0.0, noise_n=0.02)
    short = replace(deep[0], depth_mm=deep[0].depth_mm[:6], force_n=deep[0].force_n[:6])
    alone = identify_presses([short])[0]
    among = identify_presses([short, *deep[1:]])[0]
    assert abs(among["exponent"] - 2.5) < 2.0 * among["exponent_sd"]
    assert among["exponent_sd"] < 0.8 * alone["exponent_sd"]
    truth_n = (2.53 / 2.0) ** 2.5
    at_2_5_mm = [np.interp(2.5, each["model"]["depth_mm"], each["model"]["force_n"]) for each in (alone, among)]
    assert at_2_5_mm[1] == pytest.approx(truth_n, rel=0.1)
    assert abs(at_2_5_mm[1] - truth_n) < 0.5 * abs(at_2_5_mm[0] - truth_n)


def test_the_model_reaches_one_and_a_half_times_the_deepest_sample():
    (press,) = spring_presses(1)
    model = identify_presses([press])[0]["model"]
    depth_mm = np.array(model["depth_mm"])
    assert set(np.round(press.depth_mm, 4)) <= set(model["depth_mm"])
    assert (depth_mm[0], depth_mm[-1]) == (0.0, 4.5)
    assert np.all(np.diff(depth_mm) > 0.0)
    assert np.all(np.diff(model["force_n"]) >= 0.0)
    assert model["force_sd_n"][-1] > model["force_sd_n"][0] > 0.0


@pytest.mark.parametrize("noise_n", [0.003, 0.015])
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.5])
def test_a_press_that_comes_through_air_keeps_its_contact(exponent, noise_n):
    depth_mm = np.linspace(0.0, 8.0, 400)
    force_n = np.maximum(depth_mm - 5.0, 0.0) ** exponent + noise_n * np.random.default_rng(3).standard_normal(400)
    answer = identify_presses([Press(0, depth_mm, force_n)])[0]
    assert answer["contact_depth_mm"] == pytest.approx(5.0, abs=0.15)
    assert answer["stiffness_n_m"] == pytest.approx(1000.0, rel=0.15)
    assert answer["exponent"] == pytest.approx(exponent, rel=0.15)


def test_a_limited_press_of_two_samples_is_answered():
    answer = identify_presses([made([0.0, 0.3], [0.08, 4.0], "limit"), *spring_presses(10)])[0]
    assert answer["status"] != "failed"
    assert answer["stiffness_n_m"] > 2000.0


def test_a_force_beyond_the_press_is_not_known():
    answers = identify_presses(spring_presses(30, stiffness_n_m=100.0, spread=0.0))
    assert {answer["status"] for answer in answers} == {"uncertain"}, "it reaches 0.3 N"
    assert {answer["status"] for answer in identify_presses(spring_presses(30, stiffness_n_m=100.0), 0.2)} == {"known"}


def made(depths, forces, status=None):
    contact = None if status is None else Contact(status=status)
    return Press(4, np.array(depths, dtype=float), np.array(forces, dtype=float), contact=contact)


@pytest.mark.parametrize(
    ("press", "reason"),
    [
        (made([], []), "0 samples; 3 are needed"),
        (made([0, 1], [0.1, 0.5]), "2 samples; 3 are needed"),
        (made([0, 0.01, 0.02], [0.1, 0.2, 0.3]), "the depth changes by less than 0.05 mm"),
        (made([0, 1, 2], [0.0, 0.0, 0.0]), "no contact: the force does not rise with depth"),
        (made([0, 1, 2, 3], [0.5, 0.4, 0.3, 0.1]), "no contact: the force does not rise with depth"),
        (made([0, 1, 2], [0.1, 0.5, 0.9], "fail"), "the recording states that the press failed"),
    ],
)
def test_a_press_that_fails_has_a_reason_and_no_values(press, reason):
    answer = identify_presses([press, *spring_presses(3)])[0]
    nothing = {"exponent", "exponent_sd", "contact_depth_mm", "model", "misfit"}
    nothing |= {"stiffness_n_m", "stiffness_sd_n_m", "stiffness_repeat_sd_n_m"}
    assert (answer["press"], answer["status"], answer["reason"]) == (4, "failed", reason)
    assert all(answer[key] is None for key in nothing)


@pytest.mark.parametrize("status", ["ok", "limit"])
def test_a_stated_contact_is_answered_however_weak(status):
    weak = made(np.linspace(0.0, 2.0, 10), np.tile([0.004, -0.003], 5), status)
    (answer, *_) = identify_presses([weak, *spring_presses(20)])
    assert answer["status"] == "uncertain"
    assert answer["stiffness_n_m"] > 0.0


def test_a_force_that_is_not_positive_is_refused():
    with pytest.raises(ValueError, match="at_n: must be positive"):
        identify_presses(spring_presses(2), at_n=0.0)


@pytest.mark.long
def test_each_file_is_an_object_of_its_own(tmp_path: Path):
    (tmp_path / "b").mkdir()
    paths = [
        write_presses(tmp_path, spring_presses(3, exponent=1.2)),
        write_presses(tmp_path / "b", spring_presses(2, exponent=2.4)),
    ]
    lines = list(identify_stiffness(paths))
    assert [(line["file"], line["press"]) for line in lines] == [
        (str(paths[k]), press) for k, press in ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1))
    ]
    assert lines[3:] == list(identify_stiffness(paths[1:]))


@pytest.mark.parametrize("deep_mm", [0.0, 100.0])
def test_a_press_that_stays_at_its_deepest_place_is_answered(deep_mm):
    depths = np.concatenate([np.linspace(deep_mm - 1.0, deep_mm, 5), np.full(55, deep_mm)])
    forces = np.concatenate([np.zeros(30), np.full(30, 2.0)])
    (answer,) = identify_presses([made(depths, forces, "ok")])
    assert answer["status"] == "uncertain"


SAMPLES = st.integers(0, 50).flatmap(
    lambda count: st.tuples(
        arrays(np.float64, count, elements=st.floats(-100.0, 100.0)),
        arrays(np.float64, count, elements=st.floats(-20.0, 20.0)),
    )
)


def test_a_press_into_hardly_anything_has_a_stiffness():
    (answer,) = identify_presses([made(np.array([-32.0, 0.0, 0.0, 1.0]), np.array([0.0, 0.0, 2.0, -11.0]), "ok")])
    assert answer["status"] == "uncertain"
    assert answer["stiffness_n_m"] > 0.0


@pytest.mark.long
@given(st.lists(st.tuples(SAMPLES, st.sampled_from([None, "ok", "limit", "fail"])), max_size=3))
@settings(suppress_health_check=[HealthCheck.too_slow], max_examples=60)
def test_any_press_gets_an_answer_that_json_can_hold(drawn):
    answers = identify_presses([made(*columns, status) for columns, status in drawn])
    assert len(answers) == len(drawn)
    for answer in answers:
        text = json.dumps(answer, allow_nan=False)
        assert (answer["status"] == "failed") == (answer["stiffness_n_m"] is None) == (answer["model"] is None), text
        if answer["status"] != "failed":
            assert answer["stiffness_n_m"] > 0.0
            assert np.all(np.diff(answer["model"]["depth_mm"]) > 0.0)
