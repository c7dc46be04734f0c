"""A site that is stopped for a while, as a process is, and continues: nothing old is executed."""

import pytest

from tests.virtual.judge import check_ramp
from tests.virtual.session import VirtualSession

pytestmark = pytest.mark.long


@pytest.mark.parametrize("seconds", [0.15, 0.8])
@pytest.mark.parametrize("in_tick", [False, True], ids=["between", "within"])
@pytest.mark.parametrize("side", ["remote", "operator"])
def test_a_site_that_was_stopped_begins_from_neutral(
    working: VirtualSession, side: str, in_tick: bool, seconds: float
) -> None:
    """The hold times of both sites are judged at every tick, those before and after the waking too."""
    site = working.remote if side == "remote" else working.operator
    before = len(working.truth)
    (working.stop_in_tick if in_tick else working.stop)(side, seconds)
    asleep, woken_s = working.truth[before:], working.time_s
    assert asleep[-1].force_n < 1e-9  # at the very end of the ramp, but for rounding
    assert asleep[-1].peltier == 0.0
    assert site._devices.tick.held_back == in_tick
    check_ramp(working.run(0.5), woken_s)
    working.resume()


def test_a_stop_within_the_time_out_of_the_devices_is_not_felt(working: VirtualSession) -> None:
    for side in ("remote", "operator"):
        working.stop_in_tick(side, 0.05)
        for now in working.run(0.2):
            assert now.force_n > 0.2, now
    assert working.remote._devices.tick.held_back == working.operator._devices.tick.held_back == 0
