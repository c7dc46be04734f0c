"""Outputs that nobody asked for: a second sender on a bus, and devices that apply something else."""

import pytest

from tests.virtual.session import VirtualSession

pytestmark = pytest.mark.long

SOON_S = 0.4
"""Memory of what was asked for, and 100 ms of reports that are wrong."""
UNASKED = {
    "operator: intrude": "another node sends FingerForces",
    "operator: push index 5": "index: 5.00 N applied",
    "operator: motor index 2999": "the motor is driven with 2999, never asked for",
    "remote: intrude": "another node sends H",
    "remote: stuck index 1000": "the heater is driven with 1000, never asked for",
}


@pytest.mark.parametrize("fault", UNASKED)
def test_an_output_that_was_not_asked_for_latches_a_fault(working: VirtualSession, fault: str) -> None:
    begun_s = working.time_s
    working.watch.clear()  # the broken output itself is not neutral
    working.break_device(fault)
    working.until(lambda session: any(session.latched), 2.0)
    assert working.time_s - begun_s <= SOON_S
    found = working.operator.client.session.fault + working.remote.server.session.fault
    assert UNASKED[fault] in found


def test_a_person_can_work_again_once_a_second_sender_has_gone(working: VirtualSession) -> None:
    working.watch.clear()
    working.break_device("operator: intrude")
    working.until(lambda session: any(session.latched), 1.0)
    working.clear_faults()
    working.run(0.1)
    assert any(working.latched), "it is still there"
    working.mend_devices()
    working.run(1.5)
    working.clear_faults()
    working.engage()
    working.work()


def test_a_telemanipulator_that_ignores_its_release_latches_a_fault(working: VirtualSession) -> None:
    working.watch.clear()
    working.break_device("remote: cling")
    working.run(0.5)
    assert working.latched == (False, False)
    working.network.impair(cut=True)
    working.until(lambda session: session.latched[0], 1.0)
    assert "is not released, although asked for" in working.remote.server.session.fault
