"""The patient's pain in a whole session: the limit at the remote site, the report to the operator, the recording."""

from collections.abc import Iterator

import pytest

from common.limits import PAIN_LEAST_N
from common.link.session_state import Refused
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
    with pytest.raises(Refused, match="is not for the desk"):
        working.ask_desk("operator", "restore_force")
    assert gate.patient_limit_n is not None
    working.ask_desk("remote", "restore_force")
    assert gate.patient_limit_n is None
    working.run(1.0)
    assert client.remote_patient.limit_n is None
    working.resume()


def test_without_a_slider_nothing_is_reported() -> None:
    with virtual_session(patient_switch=True) as session:
        session.run_coarsely(3.0)
        assert session.operator.client.remote_patient is None
        assert "pain" not in session.remote.figures()
