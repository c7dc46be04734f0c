"""A partition of a second or of ten minutes is safe within the hold times, and work resumes by itself."""

import pytest

from common.limits import GAP_S
from operator_site.session.session_client import SILENCE_NS
from remote_site.safety.setpoints import CLEAR_HEIGHT_M, RETREAT_M_S, STOP_S
from teletaction.testbed.network import TO_OPERATOR, TO_REMOTE
from tests.virtual.judge import SERVO_S, STILL_M, check_ramp
from tests.virtual.session import TICK_S, Truth, VirtualSession

SILENCE_S = SILENCE_NS * 1e-9
RETREATED_S = GAP_S + STOP_S + (CLEAR_HEIGHT_M + 0.001) / RETREAT_M_S + SERVO_S
"""From the last motion until the remote finger is clear, from up to a millimetre below the bench."""


def assert_at_rest(truth: list[Truth], highest_m: float = CLEAR_HEIGHT_M) -> None:
    """Nothing acts on the operator or the patient, and the remote finger is still and clear of everything."""
    assert truth
    for now in truth:
        assert (now.force_n, now.motor_mv, now.peltier) == (0.0, 0, 0.0), now
        assert (now.contact_n, now.heater) == (0.0, 0.0), now
        assert CLEAR_HEIGHT_M - STILL_M <= now.z_m <= highest_m + STILL_M, now
        assert abs(now.z_m - truth[0].z_m) <= STILL_M, now


def assert_resumes_from_zero(session: VirtualSession, patience_s: float = 3.0) -> None:
    """Both sites engage by themselves within `patience_s`, force begins at zero, and the work continues."""
    session.until(lambda s: s.both_engaged, patience_s)
    engaged_s = session.time_s - TICK_S
    check_ramp(session.run(0.5), engaged_s)
    session.resume()


@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "seconds", [1.0, pytest.param(10.0, marks=pytest.mark.long), pytest.param(600.0, marks=pytest.mark.hardening)]
)
def test_a_partition_in_a_stroke_is_safe_and_the_work_resumes(working: VirtualSession, seconds: float) -> None:
    before = working.remote.server.session.ident
    working.network.impair(cut=True)
    working.run(RETREATED_S)
    assert_at_rest(working.run_coarsely(seconds - RETREATED_S))
    if seconds > 4.0:
        assert not working.operator.client.session.ident, "silence has ended the session"
        assert not working.remote.server.session.ident
    working.network.heal()
    assert_resumes_from_zero(working)
    if seconds > 4.0:
        assert working.remote.server.session.ident not in (0, before)


@pytest.mark.long
def test_a_partition_while_the_free_sensor_is_heated_is_safe_and_the_work_resumes(session: VirtualSession) -> None:
    session.hover()
    session.run(0.1)
    assert session.now.heater > 0.05
    session.network.impair(cut=True)
    session.run(1.5)  # the hold times are judged at every tick
    assert session.now.heater == 0.0
    session.network.heal()
    assert_resumes_from_zero(session)


@pytest.mark.long
def test_partitions_again_and_again_are_safe_and_the_work_resumes(working: VirtualSession) -> None:
    for seconds in (0.05, 0.12, 1.05):
        working.network.impair(cut=True)
        working.run(seconds)
        working.network.heal()
        working.resume()


@pytest.mark.long
@pytest.mark.parametrize("direction", [TO_REMOTE, TO_OPERATOR])
def test_a_cut_of_one_direction_is_safe_and_the_work_resumes(working: VirtualSession, direction: str) -> None:
    working.network.impair(direction, cut=True)
    # The side that still hears the other one learns of it when the heartbeats' answers stay away.
    working.run(SILENCE_S + 0.1 + RETREATED_S)
    assert_at_rest(working.run_coarsely(4.0))
    working.network.heal()
    assert_resumes_from_zero(working)


@pytest.mark.long
@pytest.mark.parametrize("stream", ["motion", "touch", "heartbeat"])
def test_a_cut_of_one_stream_is_safe_and_the_work_resumes(working: VirtualSession, stream: str) -> None:
    working.network.impair(stream=stream, cut=True)
    truth = working.run(5.0)
    resting = [now for now in truth if now.force_n == 0.0 and now.motor_mv == 0]
    assert len(resting) > 0.5 * len(truth)
    working.network.heal()
    working.resume()
