"""A second sender of the site's frames is found; frames of an earlier connection are no second sender."""

from common.buses.can_port import CLEAR_AFTER, SETTLING, DuplicateSender
from common.faults.fault import Fault, FaultCode

OWN, OTHER = 0x110, 0x100
"""Identifiers of FingerForces, and of HandPose."""


def settled() -> DuplicateSender:
    watch = DuplicateSender(["FingerForces"])
    for _ in range(SETTLING):
        assert not watch.step(OTHER)
    return watch


def test_one_own_frame_from_another_node_is_a_fault_until_a_long_silence() -> None:
    watch = settled()
    assert watch.fault is None
    assert watch.step(OWN)
    assert watch.fault == Fault(FaultCode.FOREIGN_FRAMES, "FingerForces")
    assert watch.heard == 1
    for _ in range(CLEAR_AFTER):
        watch.step(OTHER)
        assert watch.fault
    watch.step(OTHER)
    assert watch.fault is None


def test_frames_of_an_earlier_connection_are_no_fault_but_a_lasting_sender_is() -> None:
    watch = DuplicateSender(["FingerForces"])
    for _ in range(SETTLING):
        assert watch.step(OWN)
        assert watch.fault is None
    watch.step(OWN)
    assert watch.fault


def test_a_new_connection_restarts_the_check_and_the_count_continues() -> None:
    watch = settled()
    watch.step(OWN)
    watch.begin()
    assert watch.fault is None
    watch.step(OWN)
    assert (watch.fault, watch.heard) == (None, 1)


def test_without_own_frames_nothing_is_foreign() -> None:
    watch = DuplicateSender([])
    for _ in range(2 * SETTLING):
        assert not watch.step(OWN)
    assert watch.fault is None
