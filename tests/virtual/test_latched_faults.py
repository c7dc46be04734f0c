"""A fault latches on either site: outputs stay off until it is cleared and the session engaged again."""

from collections.abc import Callable

import pytest

from tests.virtual.session import VirtualSession
from tests.virtual.test_partition import assert_at_rest

pytestmark = pytest.mark.long

LATCHES: dict[str, Callable[[VirtualSession], None]] = {
    "disobedient telemanipulator": lambda session: session.break_device("remote: disobey drift"),
    "broken thermistor": lambda session: session.break_device("operator: thermistor index open"),
    "exoskeleton's bus off": lambda session: session.break_device("operator: bus_off"),
    "damaged frames": lambda session: session.break_device("remote: damage can crc 1"),
    "jumping encoder": lambda session: session.break_device("operator: encoder index glitch"),
    "frozen force sensor": lambda session: session.break_device("remote: force index frozen"),
    "emergency stop": VirtualSession.emergency_stop,
    "estop request": lambda session: session.ask("estop"),
}
SETTLED_S = 1.5


@pytest.fixture(params=LATCHES)
def latched(working: VirtualSession, request: pytest.FixtureRequest) -> VirtualSession:
    """A session in which a fault was latched a moment ago, and its cause is gone."""
    LATCHES[request.param](working)
    working.run(1.5)
    assert any(working.latched)
    working.mend_devices()
    working.run(SETTLED_S)
    return working


def test_nothing_acts_during_a_latched_fault_despite_requests_to_engage(latched: VirtualSession) -> None:
    for _ in range(20):
        latched.engage()
        latched.ask("engage")
        assert_at_rest(latched.run(0.2))
    assert any(latched.latched)


def test_a_fault_outlives_a_partition(latched: VirtualSession) -> None:
    latched.network.impair(cut=True)
    assert_at_rest(latched.run(3.0))
    latched.network.heal()
    assert_at_rest(latched.run(5.0))


def test_a_cleared_fault_moves_nothing_until_the_session_is_engaged_again(latched: VirtualSession) -> None:
    latched.clear_faults()
    assert_at_rest(latched.run(3.0))
    assert not any(latched.latched)
    assert not latched.both_engaged
    latched.engage()
    latched.work()
