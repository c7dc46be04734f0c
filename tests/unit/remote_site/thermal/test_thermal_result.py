"""From posterior to answer: a name is given, kept and withdrawn, and its absence has a reason."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.messages import OBJECT_UNKNOWN_SD_K, ThermalReason, ThermalStatus, explains
from remote_site.thermal.estimate_drift import HELD_S as DRIFT_HELD_S
from remote_site.thermal.material_posterior import Posterior
from remote_site.thermal.thermal_result import (
    CAUTION,
    EARLIEST_S,
    FOREIGN,
    GIVEN_UP_S,
    HELD_S,
    KEEP,
    LATEST_S,
    MISFIT,
    SET,
    SURE,
    ThermalConclusion,
    ThermalResult,
    undecided,
)

NAMES = ["metal", "stone", "plastic"]
CERTAIN = 0.5 * (1.0 + SURE)


def posterior(*probability: float, no_difference: float = 0.0, misfit: float = 1.0) -> Posterior:
    return Posterior(
        np.array(probability), 1.0 - sum(probability), 24.0, 0.3, np.log(0.5), 0.1, no_difference, misfit, 1.0
    )


def stone(sure: float) -> Posterior:
    return posterior(0.4 * (1.0 - sure), sure, 0.6 * (1.0 - sure))


def conclusion() -> ThermalConclusion:
    return ThermalConclusion(NAMES, 2000.0)


def play(concluded: ThermalConclusion, said: Posterior, from_s: float, to_s: float) -> list[ThermalResult]:
    """Answers at 100 Hz from `from_s` to `to_s`, both included."""
    return [concluded.step(said, 0.01 * k) for k in range(round(100 * from_s), round(100 * to_s) + 1)]


@pytest.mark.parametrize(("from_s", "named_s"), [(0.5, 0.5 + HELD_S), (0.01, EARLIEST_S + HELD_S)])
def test_a_name_must_be_sure_for_a_while_and_early_certainty_does_not_count(from_s: float, named_s: float) -> None:
    answers = play(conclusion(), stone(CERTAIN), from_s, named_s)
    assert {answer.status for answer in answers[:-1]} == {ThermalStatus.DECIDING}
    assert (answers[-1].status, answers[-1].material) == (ThermalStatus.IDENTIFIED, "stone")


def test_a_name_is_kept_until_it_is_doubtful() -> None:
    concluded = conclusion()
    play(concluded, stone(CERTAIN), 0.5, 1.0)
    kept = play(concluded, stone(KEEP + 0.01), 1.01, 1.5)
    assert {(answer.status, answer.material) for answer in kept} == {(ThermalStatus.IDENTIFIED, "stone")}
    assert kept[-1].probability == pytest.approx(KEEP + 0.01)
    lost = concluded.step(stone(KEEP - 0.01), 1.51)
    assert (lost.status, lost.material, lost.best) == (ThermalStatus.DECIDING, None, "stone")
    assert concluded.step(stone(KEEP + 0.01), 1.52).material is None


def test_an_uncalibrated_candidate_delays_a_name_more_than_a_calibrated_one() -> None:
    little = 0.5 * (1.0 - SURE)
    strange = posterior(0.0, 1.0 - little, 0.0)
    assert (strange.foreign, CERTAIN) == (pytest.approx(little), 1.0 - little)
    assert play(conclusion(), strange, 0.5, 1.0)[-1].status is ThermalStatus.DECIDING
    less = posterior(0.0, 1.0 - little / CAUTION, 0.0)
    answer = play(conclusion(), less, 0.5, 1.0)[-1]
    assert (answer.material, answer.probability) == ("stone", pytest.approx(1.0 - little / CAUTION))


def test_a_name_is_withdrawn_when_an_uncalibrated_candidate_becomes_likely() -> None:
    concluded = conclusion()
    play(concluded, stone(CERTAIN), 0.5, 1.0)
    assert concluded.step(posterior(0.0, 0.85, 0.0), 1.01).material == "stone"
    lost = concluded.step(posterior(0.0, 0.80, 0.0), 1.02)
    assert (lost.status, lost.best) == (ThermalStatus.DECIDING, "stone")


def test_another_name_takes_over_only_when_held() -> None:
    concluded = conclusion()
    play(concluded, stone(CERTAIN), 0.5, 1.0)
    answers = play(concluded, posterior(CERTAIN, 1.0 - CERTAIN, 0.0), 1.01, 1.01 + HELD_S)
    assert [answer.material for answer in answers[:-1]] == [None] * (len(answers) - 1)
    assert answers[-1].material == "metal"


def test_an_undecided_touch_is_ambiguous_and_its_candidates_are_named() -> None:
    concluded = conclusion()
    said = posterior(0.02, 0.5, 0.46)
    assert concluded.step(said, LATEST_S - 0.01).status is ThermalStatus.DECIDING
    answer = concluded.step(said, LATEST_S)
    assert (answer.status, answer.material) == (ThermalStatus.AMBIGUOUS, None)
    assert answer.candidates == {"stone": 0.5, "plastic": 0.46}
    assert answer.reason is ThermalReason.NONE


def test_one_candidate_is_ambiguous_against_uncalibrated_substances() -> None:
    answer = conclusion().step(posterior(0.0, 0.99, 0.0), LATEST_S)
    assert (answer.status, list(answer.candidates)) == (ThermalStatus.AMBIGUOUS, ["stone"])
    assert answer.reason == ThermalReason.NOT_RULED_OUT


def test_a_name_that_is_kept_to_the_end_needs_no_reason() -> None:
    concluded = conclusion()
    play(concluded, stone(CERTAIN), 0.5, 1.0)
    answer = concluded.step(posterior(0.0, 0.97, 0.0), LATEST_S)
    assert (answer.material, answer.reason) == ("stone", ThermalReason.NONE)


def test_an_object_of_no_calibrated_material_is_unknown_with_its_effusivity() -> None:
    rest = (1.0 - FOREIGN) / 6.0
    answer = play(conclusion(), posterior(rest, rest, rest), 0.5, 0.5 + HELD_S)[-1]
    assert (answer.status, answer.material) == (ThermalStatus.UNKNOWN, None)
    assert answer.effusivity == pytest.approx(0.5 * 2000.0)


@pytest.mark.parametrize(
    ("found", "status", "reason"),
    [
        ({"no_difference": 0.6}, ThermalStatus.UNIDENTIFIABLE, ThermalReason.NO_DIFFERENCE),
        ({"misfit": MISFIT + 0.1}, ThermalStatus.UNKNOWN, ThermalReason.NO_FIT),
    ],
)
def test_a_touch_is_not_given_up_at_once(found: dict[str, float], status: ThermalStatus, reason: ThermalReason) -> None:
    said = posterior(0.0, CERTAIN, 1.0 - CERTAIN, **found)
    concluded = conclusion()
    assert all(answer.reason is ThermalReason.NONE for answer in play(concluded, said, 0.01, GIVEN_UP_S - 0.01))
    given_up = play(concluded, said, GIVEN_UP_S, GIVEN_UP_S + HELD_S)[-1]
    assert (given_up.status, given_up.reason, given_up.material) == (status, reason, None)


def test_a_temperature_that_drifts_away_fits_no_model_until_another_finger_joins() -> None:
    concluded = conclusion()
    play(concluded, stone(CERTAIN), 0.5, 3.0)
    warmer = replace(stone(CERTAIN), object_c=stone(CERTAIN).object_c + 2.0)
    drifted = play(concluded, warmer, 3.01, 4.0)
    assert {answer.material for answer in drifted[round(100 * (DRIFT_HELD_S + HELD_S)) :]} == {None}
    assert (drifted[-1].status, drifted[-1].reason) == (ThermalStatus.UNKNOWN, ThermalReason.NO_FIT)
    assert drifted[-1].object_c_sd == OBJECT_UNKNOWN_SD_K
    back = play(concluded, stone(CERTAIN), 4.01, 5.0)[-1]
    assert back.reason is ThermalReason.NO_FIT
    joined = [concluded.step(stone(CERTAIN), 0.01 * k, ["index", "thumb"]) for k in range(501, 601)]
    assert joined[-1].material == "stone"


def test_a_misfit_states_no_temperature() -> None:
    """Rendering still uses the temperature, as before; the map, the page and the files do not."""
    missed = play(conclusion(), posterior(0.0, CERTAIN, 1.0 - CERTAIN, misfit=MISFIT + 0.1), 0.01, 2.0)
    assert {answer.object_c_sd for answer in missed if answer.reason is ThermalReason.NO_FIT} == {OBJECT_UNKNOWN_SD_K}
    foreign = play(conclusion(), posterior(0.0, 0.1, 0.1), 0.01, 2.0)[-1]
    assert (foreign.reason, foreign.object_c_sd) == (ThermalReason.NOT_CALIBRATED, 0.3)


def test_the_prior_is_reported_before_the_first_reading() -> None:
    prior = dict(zip(NAMES, (0.1, 0.2, 0.6), strict=True))
    answer = undecided(prior)
    assert answer.status is ThermalStatus.DECIDING
    assert (answer.best, answer.probability, answer.candidates) == (NAMES[2], 0.6, prior)


@st.composite
def posteriors(draw: st.DrawFn) -> Posterior:
    likely = draw(st.integers(0, 3))
    sure = draw(st.sampled_from([0.0, 0.5, KEEP - 0.01, KEEP + 0.05, SURE - 0.001, CERTAIN, 1.0]))
    share = np.full(4, (1.0 - sure) / 3.0)
    share[likely] = sure
    return Posterior(
        share[:3],
        float(share[3]),
        24.0,
        0.3,
        0.0,
        0.1,
        draw(st.sampled_from([0.0, 0.0, 0.0, 0.4, 0.9])),
        draw(st.sampled_from([1.0, 1.0, 1.0, MISFIT + 1.0])),
        1.0,
    )


@pytest.mark.long
@given(st.lists(st.tuples(posteriors(), st.integers(1, 40)), max_size=25), st.sampled_from([0.01, 0.3, 6.5]))
def test_a_name_follows_its_rules_for_all_posteriors(course: list[tuple[Posterior, int]], from_s: float) -> None:
    concluded, since_s = conclusion(), from_s
    shown: list[tuple[float, str, float]] = []
    named: set[str] = set()
    for said, readings in course:
        for _ in range(readings):
            answer = concluded.step(said, since_s)
            likely = NAMES[int(said.probability.argmax())]
            shown.append((since_s, likely, float(said.probability.max())))
            assert answer.best == likely
            assert (answer.material is not None) == (answer.status is ThermalStatus.IDENTIFIED)
            if answer.material is not None:
                assert answer.material == likely
                assert since_s >= EARLIEST_S - 1e-9
                assert said.probability.max() >= KEEP
                assert said.foreign <= FOREIGN
            if answer.material is not None and answer.material not in named:
                named.add(answer.material)
                window = [entry for entry in shown if entry[0] >= since_s - HELD_S - 1e-9]
                assert all(name == answer.material and p >= SURE for _, name, p in window)
                assert window[-1][0] - window[0][0] >= HELD_S - 1e-9
            assert answer.status is not ThermalStatus.DECIDING or since_s < LATEST_S
            assert answer.status is not ThermalStatus.AMBIGUOUS or since_s >= LATEST_S - 1e-9
            assert answer.status is not ThermalStatus.UNIDENTIFIABLE or answer.reason == ThermalReason.NO_DIFFERENCE
            assert answer.reason in (ThermalReason.NONE, ThermalReason.NOT_CALIBRATED) or since_s >= GIVEN_UP_S - 1e-9
            assert explains(answer.reason, answer.status)
            assert (answer.status is ThermalStatus.UNKNOWN) <= bool(answer.reason)
            together = list(answer.candidates.values())
            assert together == sorted(together, reverse=True)
            wanted = SET * (1.0 - said.foreign)
            assert sum(together) >= wanted - 1e-9
            assert sum(together[:-1]) < wanted + 1e-9
            since_s = round(since_s + 0.01, 2)
