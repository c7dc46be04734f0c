"""The patient's stop in a whole session: without the network, shown to the operator, cleared beside the patient."""

from collections.abc import Iterator
from itertools import pairwise

import pytest

from common.faults.fault import Fault, FaultCode
from common.faults.texts import fault_text
from common.limits import LIFT_OFF_S, PATIENT_STOP_S, SWITCH_HOLD_S
from common.link.session_state import Refused
from common.wire.packets import LinkState
from operator_site.console import texts
from tests.virtual.session import VirtualSession, virtual_session

STOPPED = Fault(FaultCode.PATIENT_STOP)


@pytest.fixture
def working() -> Iterator[VirtualSession]:
    """A session in the middle of a stroke, whose patient has a stop switch."""
    with virtual_session(patient_switch=True) as session:
        session.run_coarsely(1.7)
        session.work()
        session.run(0.5)
        yield session


def press(session: VirtualSession) -> None:
    switch = session.sim_remote.patient_switch
    assert switch is not None
    switch.press(session.time_s)


@pytest.mark.parametrize("cut", [False, True])
def test_force_falls_in_time_and_the_finger_leaves_also_without_the_network(working: VirtualSession, cut: bool) -> None:
    working.network.impair(cut=cut)
    assert working.now.contact_n > 0.1
    begun_s = working.time_s
    press(working)
    truth = working.run(LIFT_OFF_S)
    assert working.remote.server.session.fault == STOPPED
    rises_s = [b.time_s - begun_s for a, b in pairwise(truth) if b.contact_n > a.contact_n + 1e-3]
    falls_s = max(rises_s, default=0.0)
    off_s = max(entry.time_s - begun_s for entry in truth if entry.contact_n > 0.0)
    print(f"cut {cut}: falls {falls_s * 1e3:.0f} ms, off {off_s * 1e3:.0f} ms")
    assert falls_s <= PATIENT_STOP_S
    assert off_s < LIFT_OFF_S


@pytest.mark.long
def test_the_operator_sees_it_and_only_the_remote_site_clears_after_the_release(working: VirtualSession) -> None:
    switch = working.sim_remote.patient_switch
    assert switch is not None
    switch.pressed = True
    working.run(1.0)
    client = working.operator.client
    assert client.remote_fault == STOPPED
    assert fault_text(client.remote_fault).startswith("patient stopped")
    assert texts.remote_fault(STOPPED) == "Patient stopped. Remote side asks patient, then clears."
    assert not working.both_engaged
    with pytest.raises(Refused, match="released first"):
        working.ask_desk("remote", "clear_fault")
    switch.pressed = False
    working.run(SWITCH_HOLD_S + 0.1)
    working.clear_faults()  # the operator's request
    working.run(0.5)
    assert working.remote.server.session.fault == STOPPED
    assert "patient stopped" in client.refusal
    working.engage()
    working.run(0.5)
    assert not working.both_engaged
    working.ask_desk("remote", "clear_fault")
    working.run(0.5)
    assert working.remote.server.session.state is LinkState.CONNECTED
    assert client.remote_fault is None
    working.engage()
    working.resume()


@pytest.mark.long
def test_nothing_moves_while_the_switch_was_never_heard() -> None:
    with virtual_session(patient_switch=True) as session:
        session.break_device("remote: unplug patient switch")
        session.run(2.0)
        assert not session.both_engaged
        assert session.remote.server.session.fault is None
        assert "patient_switch" in session.ask_desk("remote", "status")["missing"]
        session.break_device("remote: plug patient switch")
        session.until(lambda session: session.both_engaged, 10.0)


@pytest.mark.long
def test_a_scripted_press_stops_the_session() -> None:
    with virtual_session(patient_switch=True, pressed_at_s=(0.5,)) as session:
        session.until(lambda session: session.remote.server.session.fault == STOPPED, 10.0)
