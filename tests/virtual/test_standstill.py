"""A host stands still together with its clock, as a paused virtual machine does: no old data act afterwards."""

from itertools import pairwise

import pytest

from common.limits import APPROACH_PLANE_M_S, FORCE_RAMP_UP_N_S
from common.timing.timeouts import SESSION_SILENCE_S
from teletaction.testbed.network import TO_OPERATOR, TO_REMOTE
from tests.virtual.judge import QUANTUM_N, check_ramp
from tests.virtual.session import TICK_S, Truth, VirtualSession

pytestmark = pytest.mark.long

SHORT_S = 0.08, 0.3
TIMED_OUT_S = 0.15
"""After this every device of a site that stands still is neutral by itself."""
RISE_N = FORCE_RAMP_UP_N_S * TICK_S + 2.0 * QUANTUM_N
PLACE_M = 0.001
WATCHED_S = 1.0
AGE_ERROR_S = 0.012
"""Half a round trip, and what the clock is off after a standstill."""
CLOCKS_AGREE_S = 0.3
"""After a standstill: some heartbeats by the clock that was put forward."""

sides = pytest.mark.parametrize("side", ["remote", "operator"])
ticks = pytest.mark.parametrize("in_tick", [False, True], ids=["between", "within"])


class Ages:
    """A site takes no packet for younger than it is, but for what it knows of its clock; nor, later, for older."""

    def __init__(self) -> None:
        self.agree_s = 0.0

    def __call__(self, session: VirtualSession, _: Truth) -> None:
        server, client = session.remote.server, session.operator.client
        for acceptance, host, way, uncertainty_ns in (
            (server.acceptance, session.remote_host, ("motion", TO_REMOTE), server._uncertainty_ns),
            (client.acceptance, session.operator_host, ("touch", TO_OPERATOR), client.clock.uncertainty_ns),
        ):
            came = session.network.ways[way]
            if acceptance.last_ns is None or host.now_ns() - acceptance.last_ns >= TICK_S * 1e9:
                continue
            error_s = acceptance.age_ns * 1e-9 - (came.arrived_age_s + session.time_s - came.arrived_s)
            bound_s = AGE_ERROR_S + (uncertainty_ns or 0) * 1e-9
            assert error_s >= -bound_s, (way, error_s, bound_s, session.describe())
            assert error_s <= bound_s or session.time_s < self.agree_s, (way, error_s, bound_s, session.describe())


def stand_still(working: VirtualSession, side: str, seconds: float, *, in_tick: bool) -> list[Truth]:
    """Let one host stand still with its clock; judges what follows, and returns it."""
    before_s = working.time_s
    working.watch.append(ages := Ages())
    if in_tick:
        working.stop_in_tick(side, seconds, with_clock=True)
    else:
        working.suspend(side, seconds)
    asleep, woken_s = working.now, working.time_s
    ages.agree_s = woken_s + CLOCKS_AGREE_S
    assert woken_s - before_s >= seconds - 1e-6
    after = [asleep, *working.run(WATCHED_S)]
    for before, now in pairwise(after):
        assert now.force_n - before.force_n <= RISE_N, now
        assert abs(now.x_m - asleep.x_m) <= APPROACH_PLANE_M_S * (now.time_s - woken_s) + PLACE_M, now
    if seconds >= TIMED_OUT_S:
        first = after[1]
        if side == "operator":
            assert (first.force_n, first.motor_mv, first.peltier) == (0.0, 0, 0.0), first
        assert first.heater == 0.0, first
        check_ramp(after, woken_s)
    assert working.latched == (False, False), working.describe()
    return after


@ticks
@sides
@pytest.mark.parametrize("seconds", SHORT_S)
def test_after_a_short_standstill_outputs_begin_from_neutral_and_work_resumes(
    working: VirtualSession, side: str, in_tick: bool, seconds: float
) -> None:
    assert seconds < SESSION_SILENCE_S
    working.operator.client.engages_itself = False
    stand_still(working, side, seconds, in_tick=in_tick)
    host = working.remote_host if side == "remote" else working.operator_host
    assert host.stood_still_s == pytest.approx(seconds, abs=0.012)
    working.resume()
    assert working.latched == (False, False)


@pytest.mark.parametrize(("seconds", "in_tick"), [(3.0, True), (10.0, False)])
@sides
def test_after_a_long_standstill_outputs_are_neutral_until_a_person_engages(
    working: VirtualSession, side: str, in_tick: bool, seconds: float
) -> None:
    assert seconds > SESSION_SILENCE_S
    working.operator.client.engages_itself = False
    after = stand_still(working, side, seconds, in_tick=in_tick) + working.run_coarsely(2.0)
    for now in after:
        assert (now.force_n, now.motor_mv, now.peltier, now.heater) == (0.0, 0, 0.0, 0.0), now
    assert not working.both_engaged
    working.engage()
    working.resume()
    working.run(1.0)
    assert working.latched == (False, False), working.describe()


@sides
def test_a_process_that_waits_between_its_time_and_its_devices_is_no_standstill(
    working: VirtualSession, side: str
) -> None:
    """Another program had the processor while the clock ran: what the devices say is newer than the tick's time."""
    working.stop_in_tick(side, SHORT_S[-1], before_read=True)
    working.run(1.0)
    host = working.remote_host if side == "remote" else working.operator_host
    assert host.stood_still_s == 0.0
    working.resume()
    assert working.latched == (False, False)
