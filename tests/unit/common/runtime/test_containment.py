"""Containment: an exception in a step gets a name of one line, latches a fault, and nothing else happens."""

import logging

import pytest

from common.faults.fault import LONGEST_DETAIL, Fault, FaultCode
from common.link.session_state import Refused
from common.runtime.containment import MOST_PLACES, OTHERS, Containment
from common.wire.packets import BadPacket
from tests.conftest import Contained


class Shy(RuntimeError):
    def __str__(self) -> str:
        raise ValueError("not even this can be shown")


def look_up(key: str) -> int:
    return {"known": 1}[key]


def test_an_exception_is_counted_named_with_its_place_and_latched(contained: Contained) -> None:
    latched = list[Fault]()
    contain = Containment(latched.append)
    with contain.step("render"):
        look_up("unknown")
    assert contain.count == 1
    [fault] = latched
    assert fault.code is FaultCode.CONTAINED
    name = fault.detail
    assert name.startswith("render: KeyError in test_containment.py:")
    assert name.endswith(" look_up: 'unknown'")
    assert contained.take() == [name]
    assert contain.latest == {"render": name}
    with contain.step("record", latches=False):
        look_up("unknown")
    assert latched == [fault], "what latches nothing is still named"
    assert contained.take() == [contain.latest["record"]]


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, OSError])
def test_exits_and_expected_exceptions_pass(error: type[BaseException]) -> None:
    contain = Containment()
    with pytest.raises(error), contain.step("read", passes=(OSError,)):
        raise error
    assert contain.count == 0


@pytest.mark.parametrize("error", [MemoryError, RecursionError, AssertionError, Shy])
def test_every_other_exception_is_contained(error: type[Exception], contained: Contained) -> None:
    contain = Containment()
    with contain.step("read"):
        raise error
    assert contain.count == len(contained.take()) == 1


def test_text_of_a_peer_makes_no_second_line_and_no_long_one(contained: Contained) -> None:
    latched = list[Fault]()
    with Containment(latched.append).step("session"):
        look_up("\x1b[31m\nERROR a forged line\r" + "x" * 10_000)
    [fault] = latched
    assert fault.code is FaultCode.CONTAINED
    name = fault.detail
    assert name.isprintable()
    assert len(name) <= LONGEST_DETAIL
    assert contained.take() == [name]


def test_a_place_is_logged_once_until_the_fault_is_cleared(
    caplog: pytest.LogCaptureFixture, contained: Contained
) -> None:
    contain = Containment()

    def fail() -> None:
        with contain.step("render"):
            look_up("unknown")

    for _ in range(3):
        fail()
    assert len(caplog.records) == len(contained.take()) == 1
    assert caplog.records[0].levelno == logging.ERROR
    contain.not_latched()
    fail()
    contain.not_latched()
    contain.not_latched()
    fail()
    assert len(caplog.records) == 3
    assert contain.count == 5
    assert list(contain.places.values()) == [5]
    assert len(contained.take()) == 2


def test_an_unbounded_number_of_places_is_counted_together(contained: Contained) -> None:
    contain = Containment()
    for number in range(MOST_PLACES + 10):
        with contain.step(f"step {number}"):
            look_up("unknown")
    assert len(contain.places) == MOST_PLACES + 1
    assert contain.places[OTHERS] == 10
    assert len(contained.take()) == MOST_PLACES + 1


def test_a_request_that_raises_is_refused_and_latches_nothing_and_a_refusal_stays_one(contained: Contained) -> None:
    latched = list[Fault]()
    contain = Containment(latched.append)
    with pytest.raises(Refused, match="this site failed at the request: control: KeyError"), contain.request("control"):
        look_up("unknown")
    assert contain.count == len(contained.take()) == 1
    for refusal in (Refused, BadPacket):
        with pytest.raises(refusal, match="not now"), contain.request("control"):
            raise refusal("not now")
    assert contain.count == 1
    assert not latched
