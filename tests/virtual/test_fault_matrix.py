"""Every fault of the table that needs no real process, on the test bed, judged at the simulated actuators."""

import pytest

from robustness.fault_judge import Finding
from robustness.faults import GROUPS, PATIENT, opener, run_apart, virtual
from robustness.virtual_fault_session import VirtualFaultSession

pytestmark = pytest.mark.timeout(600)

PIECES = {
    "network": virtual(GROUPS["network"]),
    "devices, first half": virtual(GROUPS["devices"])[: len(GROUPS["devices"]) // 2],
    "devices, second half": virtual(GROUPS["devices"])[len(GROUPS["devices"]) // 2 :],
    "plate": virtual(GROUPS["plate"]),
    PATIENT: virtual(GROUPS[PATIENT]),
    "processes": virtual(GROUPS["processes"]),
}
"""Each is a session of its own, so that several processors share them."""


@pytest.mark.parametrize("piece", PIECES)
def test_faults_have_the_outcomes_of_the_table(piece: str) -> None:
    findings: list[Finding] = run_apart(PIECES[piece], print, opener(piece, VirtualFaultSession))
    assert {finding.fault.name: finding.wrong for finding in findings if finding.wrong} == {}
    assert len(findings) == len(PIECES[piece])


def test_every_fault_is_tested() -> None:
    done = [fault for faults in PIECES.values() for fault in faults]
    assert sorted(fault.key for fault in done) == sorted(
        fault.key for faults in GROUPS.values() for fault in virtual(faults)
    )
