"""A fault latches on either site: nothing is put out until it is cleared and the session engaged again."""

from collections.abc import Callable

import pytest

from tests.virtual.session import VirtualSession
from tests.virtual.test_partition import assert_at_rest

pytestmark = pytest.mark.long

LATCHES: dict[str, Callable[[VirtualSession], None]] = {
    "disobedient telemanipulator": lambda session: session.break_device("remote: disobey drift"),
    "broken thermistor": lambda session: session.break_device("operator: thermistor index open"),
    "emergency stop": VirtualSession.emergency_stop,
    "estop request": lambda session: session.ask("estop"),
}
"""One of each kind; the fault matrix has every fault that latches."""
SETTLED_S = 1.5


@pytest.mark.parametrize("cause", LATCHES)
def test_nothing_acts_until_a_fault_is_cleared_and_the_session_engaged_again(
    working: VirtualSession, cause: str
) -> None:
    """Neither a wish to engage nor a partition ends the latch, and clearing alone moves nothing."""
    LATCHES[cause](working)
    working.run(1.5)
    assert any(working.latched)
    working.mend_devices()
    working.run_coarsely(SETTLED_S)
    for _ in range(10):
        working.engage()
        working.ask("engage")
        assert_at_rest(working.run_coarsely(0.2))
    working.network.impair(cut=True)
    assert_at_rest(working.run_coarsely(2.0))
    working.network.heal()
    assert_at_rest(working.run_coarsely(3.0))
    assert any(working.latched)
    working.clear_faults()
    assert_at_rest(working.run(0.5) + working.run_coarsely(1.5))
    assert not any(working.latched)
    assert not working.both_engaged
    working.engage()
    working.resume()
