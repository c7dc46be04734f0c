"""A fault latches on either site: nothing is put out until it is cleared and the session engaged again."""

from collections.abc import Callable

import pytest

from remote_site.safety.setpoints import CLEAR_HEIGHT_M, HEIGHT_HIGH_M
from tests.virtual.session import Truth, VirtualSession
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
    # Set-points rise further while the finger of a broken drive presses.
    highest_m = HEIGHT_HIGH_M if cause == "disobedient telemanipulator" else CLEAR_HEIGHT_M

    def assert_safe(truth: list[Truth]) -> None:
        assert_at_rest(truth, highest_m)

    LATCHES[cause](working)
    working.run(1.5)
    assert any(working.latched)
    working.mend_devices()
    working.run_coarsely(SETTLED_S)
    for _ in range(10):
        working.engage()
        working.ask("engage")
        assert_safe(working.run_coarsely(0.2))
    working.network.impair(cut=True)
    assert_safe(working.run_coarsely(2.0))
    working.network.heal()
    assert_safe(working.run_coarsely(3.0))
    assert any(working.latched)
    working.clear_faults()
    assert_safe(working.run(0.5) + working.run_coarsely(1.5))
    assert not any(working.latched)
    assert not working.both_engaged
    working.engage()
    working.resume()
