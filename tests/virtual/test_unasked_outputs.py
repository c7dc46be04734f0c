"""Outputs without a command: a second sender on a bus, and devices that apply something else."""

import pytest

from common.faults.fault import EXOSKELETON, TELEMANIPULATOR, Fault, FaultCode
from tests.virtual.session import VirtualSession

pytestmark = pytest.mark.long

SOON_S = 0.4
"""Memory of what was asked for, and 100 ms of reports that are wrong."""
UNASKED = {
    "operator: intrude": Fault(FaultCode.FOREIGN_FRAMES, "FingerForces", EXOSKELETON),
    "operator: push index 5": Fault(FaultCode.FORCE_UNASKED, "index", EXOSKELETON),
    "operator: motor index 2999": Fault(FaultCode.MOTOR_UNASKED, "index", value=2999.0),
    "remote: intrude": Fault(FaultCode.FOREIGN_FRAMES, device=TELEMANIPULATOR),
    "remote: stuck index 1000": Fault(FaultCode.HEATER_UNASKED, "index", value=1000.0),
}


@pytest.mark.parametrize("fault", UNASKED)
def test_an_output_without_a_command_latches_a_fault(working: VirtualSession, fault: str) -> None:
    begun_s = working.time_s
    working.watch.clear()  # the broken output itself is not neutral
    working.break_device(fault)
    working.until(lambda session: any(session.latched), 2.0)
    assert working.time_s - begun_s <= SOON_S
    found = working.operator.client.session.fault or working.remote.server.session.fault
    assert found is not None
    expected = UNASKED[fault]
    assert (found.code, found.device) == (expected.code, expected.device)
    assert expected.where in ("", found.where)
    assert expected.value in (None, found.value)


def test_work_can_resume_once_a_second_sender_is_gone(working: VirtualSession) -> None:
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
    working.resume()


def test_a_telemanipulator_that_ignores_its_release_latches_a_fault(working: VirtualSession) -> None:
    working.watch.clear()
    working.break_device("remote: cling")
    working.run(0.5)
    assert working.latched == (False, False)
    working.network.impair(cut=True)
    working.until(lambda session: session.latched[0], 1.0)
    assert working.remote.server.session.fault == Fault(FaultCode.NOT_RELEASED, device=TELEMANIPULATOR)
