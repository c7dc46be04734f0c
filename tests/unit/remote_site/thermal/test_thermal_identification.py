"""Thermal identification of touches made by another physics, with a table calibrated from such touches."""

from pathlib import Path

import numpy as np
import pytest

from common.wire.messages import ThermalReason, ThermalStatus
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge
from remote_site.thermal.thermal_result import EARLIEST_S, NO_CONTACT, ThermalResult
from tests.places import TABLES
from tests.unit.remote_site.made_touches import (
    AMBIENT_C,
    MATERIALS,
    SENSOR,
    MadeMaterial,
    MadeTouch,
    made_touches,
    true_table,
)
from tests.unit.remote_site.played_touches import names, play, touching

pytestmark = pytest.mark.long

EACH = 4
"""Fresh touches of each material."""


@pytest.fixture(scope="module")
def answered(calibrated_knowledge: ThermalKnowledge) -> list[tuple[MadeTouch, list[ThermalResult]]]:
    """Fresh touches and their answers, 100 a second, for 7 s."""
    return [
        (touch, play(calibrated_knowledge, touch.until(7.0)))
        for seed, name in enumerate(MATERIALS)
        for touch in made_touches(name, EACH, seed=500 + seed)
    ]


Answered = list[tuple[MadeTouch, list[ThermalResult]]]


def test_calibration_finds_the_sensor_and_the_materials(calibrated: tuple[MaterialTable, Path]) -> None:
    table = calibrated[0]
    assert table.names() == list(MATERIALS)
    assert table.leak_per_s * table.plate_j_m2k == pytest.approx(SENSOR.leak_w_m2k, rel=0.15)
    assert np.exp(table.ln_lag) == pytest.approx(SENSOR.lag_s, rel=0.05)
    for entry, material in zip(table.materials, MATERIALS.values(), strict=True):
        assert table.effusivity(entry.ln_effusivity) == pytest.approx(material.effusivity, rel=0.15)
        assert entry.misfit == pytest.approx(1.0, abs=0.4)
        assert abs(entry.offset_k) < 3.0


def test_materials_are_named_rightly_and_not_early_and_always_with_a_probability(answered: Answered) -> None:
    for touch, answers in answered:
        assert names(answers) <= {touch.name}
        assert names(answers[: round(100 * EARLIEST_S) - 1]) == set()
        assert all(0.0 <= answer.probability <= 1.0 and answer.best in MATERIALS for answer in answers)
    named = [answers[-1].status is ThermalStatus.IDENTIFIED for _, answers in answered]
    assert np.mean(named) >= 0.8, "caution leaves few unnamed"
    assert all(answers[-1].best == touch.name for touch, answers in answered)
    # after half a second already; guessing would be right in a third
    assert np.mean([answers[49].best == touch.name for touch, answers in answered]) >= 0.9


def test_temperature_and_effusivity_are_within_their_uncertainty(answered: Answered) -> None:
    squares = []
    for touch, answers in answered:
        answer = answers[-1]
        assert None not in (answer.object_c, answer.object_c_sd, answer.effusivity, answer.effusivity_ln_sd)
        assert answer.object_c == pytest.approx(touch.object_c, abs=1.0)
        squares.append(((answer.object_c - touch.object_c) / answer.object_c_sd) ** 2)
        squares.append((np.log(answer.effusivity / touch.effusivity) / answer.effusivity_ln_sd) ** 2)
    # the mean square of 24 standard normal numbers is below 2.3 in 99.9 %
    assert np.mean(squares) < 2.3


def test_the_papers_method_is_reported_beside_the_result(answered: Answered) -> None:
    for touch, answers in answered:
        assert answers[10].rate_per_s is None
        last = answers[-1]
        assert last.rate_per_s is not None
        assert last.exponential_material in MATERIALS
        assert last.exponential_object_c is not None
        assert touch.object_c - 1.0 < last.exponential_object_c < touch.start_c
    metal = [answers[-1].exponential_material for touch, answers in answered if touch.name == "metal"]
    assert metal.count("metal") >= EACH - 1


@pytest.mark.parametrize(
    ("name", "seed", "start_c", "object_c", "off_k"),
    [("stone", 21, 27.0, 22.0, 0.5), ("stone", 21, 40.0, 22.0, 0.5), ("metal", 22, AMBIENT_C, 33.0, 0.3)],
    ids=["less warm", "warmer", "colder than its object"],
)
def test_another_preheat_needs_no_other_table(
    calibrated_knowledge: ThermalKnowledge, name: str, seed: int, start_c: float, object_c: float, off_k: float
) -> None:
    (touch,) = made_touches(name, 1, seed, start_c=start_c, object_c=object_c)
    answer = play(calibrated_knowledge, touch.until(7.0))[-1]
    assert answer.best == name
    assert answer.material in (None, name)
    assert answer.object_c == pytest.approx(object_c, abs=off_k)


def test_an_unusual_contact_makes_no_other_material(knowledge: ThermalKnowledge) -> None:
    """Contacts that scatter by 12 %, as they are calibrated to: one in twenty is beyond two standard deviations.

    Taken for `unknown` at most as often as anything may be foreign.
    """
    materials = {
        name: MadeMaterial(m.effusivity, m.conductance_w_m2k, piece_sd=m.piece_sd, contact_sd=0.12)
        for name, m in MATERIALS.items()
    }
    wide = ThermalKnowledge.of(true_table(materials))
    touches = made_touches("metal", 12, seed=1, seconds=3.0, material=materials["metal"])
    ends = [play(wide, touch)[-1] for touch in touches]
    assert {answer.material for answer in ends} <= {None, "metal"}
    assert [answer.status for answer in ends].count(ThermalStatus.UNKNOWN) <= 1


def test_a_finished_touch_keeps_its_answer_until_its_release(knowledge: ThermalKnowledge) -> None:
    (touch,) = made_touches("stone", 1, seed=24, seconds=knowledge.table.lasts_s + 0.5)
    identification = touching(knowledge, touch)
    for row in touch.after():
        identification.step(*row)
    assert not identification.running
    done = identification.answer
    identification.stop(ThermalReason.CONTACT_LOST)
    assert identification.answer is done
    identification.release()
    assert identification.answer is NO_CONTACT
    assert identification.evidence() is None


def test_each_touch_starts_a_new_identification(knowledge: ThermalKnowledge) -> None:
    first, second = (made_touches(name, 1, seed=25, seconds=2.5)[0] for name in ("metal", "plastic"))
    used = ThermalIdentification(knowledge)
    for from_s, touch in ((0.0, first), (100.0, second)):
        used.start(from_s, touch.start_c, 0.0, AMBIENT_C)
        for t_s, sensor_c, force_n in touch.after():
            used.step(from_s + t_s, sensor_c, force_n)
    fresh = play(knowledge, second)[-1]
    assert used.answer.best == fresh.best == "plastic"
    assert used.answer.probability == pytest.approx(fresh.probability, abs=1e-6)
    assert used.answer.object_c == pytest.approx(fresh.object_c, abs=1e-6)


def test_readings_out_of_contact_count_for_nothing(knowledge: ThermalKnowledge) -> None:
    identification = ThermalIdentification(knowledge)
    assert identification.step(0.0, 33.0, 1.2) is NO_CONTACT
    assert identification.evidence() is None


def test_a_table_survives_its_file_and_a_foreign_one_is_refused(
    calibrated: tuple[MaterialTable, Path], tmp_path: Path
) -> None:
    table, path = calibrated
    assert MaterialTable.load(path).materials == table.materials
    with pytest.raises(ValueError, match="cannot be read"):
        MaterialTable.load(tmp_path / "none.json")
    (tmp_path / "other.json").write_text('{"kind": "texture_surfaces"}')
    with pytest.raises(ValueError, match="not a thermal_materials table"):
        MaterialTable.load(tmp_path / "other.json")
    text = path.read_text()
    (tmp_path / "edited.json").write_text(text.replace('"ambient_c": 2', '"ambient_c": 1', 1))
    with pytest.raises(ValueError, match="content_hash"):
        MaterialTable.load(tmp_path / "edited.json")
    (tmp_path / "old.json").write_text(text.replace('"schema_version": 4', '"schema_version": 2', 1))
    with pytest.raises(ValueError, match="schema_version 2, this program reads 3"):
        MaterialTable.load(tmp_path / "old.json")


def test_the_shipped_table_of_pieces_of_any_kind_loads() -> None:
    assert MaterialTable.load(TABLES / "materials.json").names() == ["aluminium", "ceramic_tile", "pine", "pvc"]
