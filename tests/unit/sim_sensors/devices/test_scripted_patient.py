"""The simulated patient answers one reaction time after the threshold of the place is exceeded."""

import pytest

from common.scenes.tender import TenderSpot
from sim_sensors.devices.scripted_patient import ScriptedPatient

SPOT = TenderSpot(x_m=0.1, y_m=0.02, threshold_n=2.0, surround_n=8.0, width_m=0.01)


def answers(force_n: float, x_m: float = 0.1, seconds: float = 2.0) -> list[tuple[float, float]]:
    patient, found = ScriptedPatient([SPOT], 0.6), []
    for tick in range(round(seconds * 100)):
        now_s = 0.01 * tick
        patient.step(now_s, x_m, [0.0, 0.02], [0.0, force_n if now_s < 1.0 else 0.0])
        found.append((now_s, patient.pain))
    return found


def test_pain_begins_and_ends_one_reaction_time_late() -> None:
    painful = [now_s for now_s, pain in answers(3.0) if pain > 0.0]
    assert painful[0] == pytest.approx(0.6, abs=0.011)
    assert painful[-1] == pytest.approx(1.6, abs=0.021)


def test_more_force_is_more_pain_up_to_the_end_of_the_slider() -> None:
    highest = [max(pain for _, pain in answers(force_n)) for force_n in (1.9, 2.1, 3.0, 4.0, 9.0)]
    assert highest == sorted(highest)
    assert (highest[0], highest[-1]) == (0.0, 1.0)


def test_beside_the_spot_the_patient_bears_more() -> None:
    assert max(pain for _, pain in answers(3.0, x_m=0.115)) == 0.0
    assert max(pain for _, pain in answers(9.0, x_m=0.2)) > 0.0


def test_a_patient_without_a_tender_spot_feels_no_pain() -> None:
    patient = ScriptedPatient([], 0.6)
    for tick in range(200):
        patient.step(0.01 * tick, 0.1, [0.0], [5.0])
    assert patient.pain == 0.0
