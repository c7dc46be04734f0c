"""A hundred textures: on made-up models everywhere, on the public ones where TELETACTION_DATA has them."""

from unittest.mock import Mock

import numpy as np
import pytest
from matplotlib.figure import Figure

from studies.running import Unavailable
from studies.texture_world import rendering_quality, roughness, strokes
from studies.texture_world.figure import draw_motion, draw_names, draw_roughness, draw_similarity, draw_spectra
from studies.texture_world.models import read_models
from studies.texture_world.recognition import LONGEST_S, METHODS, SHIPPED, named, ranks, strangers
from studies.texture_world.rendering_quality import BITS, MISSING, installed, quantised, resounded, similarities, turned
from studies.texture_world.roughness import ranking, roughnesses, sensor_law
from studies.texture_world.run import accuracy, by_motion, by_texture, pooled, run
from tests.places import DATA
from tests.unit.studies.texture_world.made_models import models_in

RATE_HZ = 1000.0


def public():
    """Public models; skips the test without them."""
    try:
        return read_models(DATA / "textures")
    except Unavailable as absent:
        pytest.skip(f"{absent}; TELETACTION_DATA names the folder that holds textures")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The study over ten made-up models, without the package of the metrics."""
    models = models_in(tmp_path_factory.mktemp("world") / "textures", 10)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rendering_quality, "PACKAGE", "no_such_package")
        patch.setenv("TELETACTION_DATA", str(models.parent))
        return run(quick=True, seed=0, progress=lambda _: None)


@pytest.mark.long
def test_made_up_textures_are_ranked_and_named(made):
    assert made["roughness"]["spearman_five_strokes"] > 0.5
    whole = {row["method"]: row for row in made["accuracy"] if row["seconds"] == LONGEST_S}
    assert whole[SHIPPED]["top_1"] > 0.6
    assert whole[SHIPPED]["top_1"] <= whole[SHIPPED]["top_3"]
    assert set(whole) == set(METHODS)
    assert made["without"] == [MISSING]
    assert made["quality"] == []
    assert len(made["by_texture"]) == len(made["textures"]) == 10


@pytest.mark.long
def test_panels_are_drawn(made):
    panels = Figure().subplots(5, 1).flat
    for axes, draw in zip(
        panels, (draw_roughness, draw_names, draw_motion, draw_similarity, draw_spectra), strict=True
    ):
        draw(axes, made)
        assert axes.get_title(loc="left")
    assert [text.get_text() for text in axes.texts] == [MISSING]


@pytest.mark.long
def test_public_textures_are_named_better_than_by_classic_methods_and_strangers_are_unknown():
    models = public()
    found = {row["method"]: row for row in accuracy(list(named(models, 2, 77))) if row["seconds"] == LONGEST_S}
    others = max(row["top_1"] for method, row in found.items() if method != SHIPPED)
    assert found[SHIPPED]["top_1"] > others + 0.1
    assert found[SHIPPED]["top_3"] > 0.75
    apart = {row["seconds"]: row for row in pooled(list(strangers(models, 2, 77, 1, "many")))}
    assert apart[LONGEST_S]["strange_unknown_share"] >= 0.75
    assert apart[LONGEST_S]["own_right_share"] > 0.25


@pytest.mark.long
def test_roughness_ranks_public_textures_as_their_own_power_does():
    models = public()
    found = ranking(list(roughnesses(models[::5], range(20), sensor_law(models, 77), 77)))
    assert found["spearman_five_strokes"] >= 0.85
    assert found["textures"] == 20


def test_no_two_strokes_share_their_chance(tmp_path, monkeypatch):
    """The first draws of a generator show its seed, whichever way it is written."""
    models, first = read_models(models_in(tmp_path / "textures", 10)), []
    fresh = np.random.default_rng

    def noted(seed):
        first.append(fresh(seed).integers(2**62))
        return fresh(seed)

    monkeypatch.setattr(np.random, "default_rng", noted)
    for module in (strokes, rendering_quality):
        monkeypatch.setattr(module, "rendered", lambda model, speed, force, chance: speed)
    monkeypatch.setattr(roughness, "fit_law", Mock())
    monkeypatch.setattr(roughness, "mean_ln_roughness", Mock())
    monkeypatch.setattr(rendering_quality, "installed", lambda: True)
    monkeypatch.setattr(rendering_quality, "similarities", lambda *_: {})
    monkeypatch.setattr(rendering_quality, "turned", lambda rpm: np.repeat(rpm, 2))
    sensor_law(models, 0)
    list(roughnesses(models, range(10), None, 0))
    list(rendering_quality.qualities(models, range(10), [0.0] * 10, 0))
    assert len(first) == 10 * (2 + 6 + 2)
    assert len(set(first)) == len(first)


@pytest.mark.parametrize("count", [1, 9])
def test_too_few_textures_are_refused(count, tmp_path, monkeypatch):
    models_in(tmp_path / "textures", count)
    monkeypatch.setenv("TELETACTION_DATA", str(tmp_path))
    with pytest.raises(Unavailable, match=f"textures: {count} texture models, fewer than 10"):
        run(quick=False, seed=0, progress=lambda _: None)


def test_shares_are_counted():
    rows = [
        {"method": SHIPPED, "seconds": 1.0, "material": "a", "ln_speed": 0.1 * k, "ln_force": -0.1 * k, "rank": k % 4}
        for k in range(40)
    ]
    (row,) = (row for row in accuracy_of(rows) if row["method"] == SHIPPED and row["seconds"] == 1.0)
    assert (row["top_1"], row["top_3"], row["strokes"]) == (0.25, 0.75, 40)
    assert sum(cell["strokes"] for cell in by_motion(rows)) == 40
    assert by_texture(rows, seconds=1.0) == [{"material": "a", "strokes": 40, "top_1": 0.25}]


def test_a_texture_with_the_probability_0_of_many_is_behind_all_of_them():
    score = np.array([[1.0, 0.0, 0.0, 0.0], [0.6, 0.3, 0.1, 0.0], [0.4, 0.4, 0.2, 0.0]])
    assert ranks(score, np.array([2, 1, 0])).tolist() == [3, 1, 1]


def accuracy_of(rows):
    """Shares where each method has judged the same strokes at each duration."""
    return accuracy(
        [row | {"method": method, "seconds": seconds} for row in rows for method in METHODS for seconds in SECONDS]
    )


SECONDS = (0.15, 0.25, 0.5, 1.0, 2.0, LONGEST_S)


def test_more_bits_are_nearer_to_the_signal():
    signal = np.random.default_rng(1).normal(size=4000)
    errors = [float(np.std(quantised(signal, bits) - signal)) for bits in BITS]
    assert errors == sorted(errors, reverse=True)
    assert len(set(quantised(signal, 1))) == 2
    assert errors[-1] < 0.02


def test_resounded_noise_has_the_spectrum_and_not_the_course():
    chance = np.random.default_rng(2)
    signal = np.convolve(chance.normal(size=8000), np.hanning(9), "same")
    shown = resounded(signal, 4.0, chance)
    assert shown[500:-500].std() == pytest.approx(signal.std(), rel=0.1)
    assert abs(np.corrcoef(shown, signal)[0, 1]) < 0.1


def test_a_motor_that_turns_steadily_shows_one_frequency():
    shown = turned(np.full(1000, 6000.0))[1000:]
    power = np.abs(np.fft.rfft(shown * np.hanning(len(shown)))) ** 2
    assert np.argmax(power) * RATE_HZ / len(shown) == pytest.approx(100.0, rel=0.1)
    assert power[np.argmax(power) - 3 : np.argmax(power) + 4].sum() > 0.99 * power.sum()


@pytest.mark.exports
def test_the_metrics_are_one_for_equal_signals_and_fall_with_the_bits():
    assert installed()
    signal = np.random.default_rng(3).normal(size=4000)
    scores = [similarities(quantised(signal, bits), signal) for bits in (1, 4, 8)]
    for name in ("st_sim", "spqi"):
        assert [score[name] for score in scores] == sorted(score[name] for score in scores)
        assert scores[-1][name] > 0.9
    assert similarities(signal, signal) == {"st_sim": 1.0, "spqi": 1.0}
    assert similarities(-signal, signal)["st_sim"] == 0.0
