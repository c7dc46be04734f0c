"""Simulated patients with a tender place: it is found, and few presses exceed their threshold."""

from pathlib import Path

import numpy as np
import pytest

from studies.tenderness.examiner import examine
from studies.tenderness.figure import plot
from studies.tenderness.patients import Kind, Patient
from studies.tenderness.run import KINDS, run
from tests.unit.studies.written import draw_figure


def test_a_patient_answers_one_reaction_time_after_the_threshold():
    kind = Kind("exact", noise=0.0, wrong=0.0)
    reactions = []
    for seed in range(20):
        patient = Patient(kind, seed)
        x_m, y_m = patient.centres_m[0]
        assert patient.mean_threshold_n(x_m, y_m) == pytest.approx(patient.threshold_n)
        assert patient.mean_threshold_n(x_m + 0.1, y_m) > 1.7 * patient.threshold_n
        pressed = patient.press(0.0, x_m, y_m, 5.0)
        if not pressed.answer.any():
            continue
        first = int(np.argmax(pressed.answer > 0.0))
        crossed = int(np.argmax(pressed.force_n > patient.threshold_n))
        reaction_s = pressed.time_s[first] - pressed.time_s[crossed]
        assert reaction_s == pytest.approx(patient.reaction_s, rel=0.4, abs=0.05)
        reactions.append(reaction_s / patient.reaction_s)
        assert pressed.exceeded
        assert pressed.force_n[-1] < 0.1
    assert len(reactions) >= 17, "3 % of the answers are missed"
    assert np.mean(reactions) == pytest.approx(1.0, abs=0.1)


def test_a_light_press_brings_no_answer():
    patient = Patient(Kind("exact", wrong=0.0), 3)
    pressed = patient.press(0.0, 0.0, 0.0, 0.2)
    assert not pressed.answer.any()
    assert not pressed.exceeded


@pytest.mark.long
def test_after_the_first_report_the_examiner_stays_within_the_limit():
    kind = KINDS[0]
    patient = Patient(kind, 0)
    done = examine(patient, kind, 0)
    assert done.presses > done.after > 0
    assert done.exceeded <= 0.05 * done.after
    assert examine(Patient(kind, 0), kind, 0).place() == done.place(), "the same seed gives the same examination"


@pytest.mark.study
def test_the_study_reaches_its_goals_in_brief(tmp_path: Path) -> None:
    data = run(quick=True, seed=1, progress=lambda _: None)
    assert data["problems"] == []
    assert len(data["conditions"]) == len(KINDS)
    draw_figure(plot, data, tmp_path)
