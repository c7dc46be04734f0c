"""The patient's pain in a whole session: the limit at the remote site, the report to the operator, the recording."""

from collections.abc import Iterator

import pytest

from common.limits import PAIN_LEAST_N, PAIN_SHARE
from common.link.session_state import Refused
from common.scenes.tender import TenderSpot
from sim_sensors.devices.scripted_patient import ScriptedPatient
from tests.virtual.session import VirtualSession, virtual_session


@pytest.fixture
def working() -> Iterator[VirtualSession]:
    """A session in the middle of a stroke, whose patient has a pain slider."""
    with virtual_session(patient_switch=True) as session:
        slide(session, 0.0)
        session.run_coarsely(1.7)
        session.work()
        session.run(0.5)
        yield session


def slide(session: VirtualSession, pain: float) -> None:
    switch = session.sim_remote.patient_switch
    assert switch is not None
    switch.pain = pain


@pytest.mark.long
def test_pain_lowers_the_limit_reaches_the_operator_and_a_person_ends_it(working: VirtualSession) -> None:
    gate, client = working.remote.gate, working.operator.client
    working.run(1.5)
    assert client.remote_patient is not None
    assert client.remote_patient[:2] == (0.0, None)
    assert working.now.contact_n > 0.1
    slide(working, 0.6)
    working.run(1.5)
    assert gate.patient_limit_n is not None
    assert gate.patient_limit_n >= PAIN_LEAST_N
    shown = client.remote_patient
    assert shown.pain == pytest.approx(6.0)
    assert shown.limit_n == gate.patient_limit_n
    assert [report.answer for report in shown.reports] == [pytest.approx(6.0)]
    with pytest.raises(Refused, match="slider has to be at 0"):
        working.ask_desk("remote", "restore_force")
    slide(working, 0.0)
    working.run(1.0)
    with pytest.raises(Refused, match="only the remote site can do this"):
        working.ask_desk("operator", "restore_force")
    assert gate.patient_limit_n is not None
    working.ask_desk("remote", "restore_force")
    assert gate.patient_limit_n is None
    working.run(1.0)
    assert client.remote_patient.limit_n is None
    working.resume()


@pytest.mark.long
def test_without_a_slider_nothing_is_reported() -> None:
    with virtual_session(patient_switch=True) as session:
        session.run_coarsely(3.0)
        assert session.operator.client.remote_patient is None
        assert "pain" not in session.remote.figures()


@pytest.mark.long
def test_the_scripted_patient_answers_from_the_places_of_the_scene() -> None:
    with virtual_session(patient_switch=True) as session:
        spot = TenderSpot(x_m=0.15, y_m=-0.02, threshold_n=0.3, surround_n=0.5, width_m=0.1)
        session.sim_remote._patient = ScriptedPatient([spot], 0.5)
        limits_n = []
        for _ in range(16):
            session.run_coarsely(0.5)
            limits_n.append(session.remote.gate.patient_limit_n)
        known_n = [limit_n for limit_n in limits_n if limit_n is not None]
        assert limits_n[0] is None
        assert known_n == sorted(known_n, reverse=True)
        assert known_n[-1] == pytest.approx(PAIN_SHARE**3 * known_n[0]), "pain lasts for 4 s of the stroke"
        assert session.operator.client.remote_patient is not None
        assert session.operator.client.remote_patient.limit_n == known_n[-1]
