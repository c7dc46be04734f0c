"""A site's clock is stepped: outputs are neutral while the sites do not know each other's time, and work resumes."""

import pytest

from common.limits import GAP_S
from tests.virtual.judge import check_operator_safe
from tests.virtual.session import VirtualSession

RESUMED_S = 5.0
STEPS = [
    ("remote", 10.0),
    ("operator", -10.0),
    pytest.param("remote", -10.0, marks=pytest.mark.long),
    pytest.param("operator", 10.0, marks=pytest.mark.long),
]


def step_clock(session: VirtualSession, side: str, seconds: float) -> None:
    """Set one site's clock."""
    clock = session.remote_clock if side == "remote" else session.operator_clock
    clock.offset_s += seconds


@pytest.mark.long
@pytest.mark.parametrize(("side", "seconds"), STEPS)
def test_a_stepped_clock_is_safe_at_once_and_the_work_resumes_with_plate_and_motor(
    working: VirtualSession, side: str, seconds: float
) -> None:
    client, server = working.operator.client, working.remote.server
    step_clock(working, side, seconds)
    stepped_s, received = working.time_s, client.acceptance.received

    def touch_accepted(session: VirtualSession) -> bool:
        if client.acceptance.received > received:
            return True
        check_operator_safe(session.now, session.time_s - stepped_s)
        return False

    working.until(touch_accepted, RESUMED_S)
    motions = server.acceptance.received
    working.until(lambda _: working.both_engaged and server.acceptance.received > motions, RESUMED_S)
    working.work()
    moments = working.run(1.0)
    assert len({now.peltier for now in moments}) > 3, "a drive that never changes regulates nothing"
    assert len({now.motor_mv for now in moments if now.motor_mv}) != 1, "a speed that never changes is not the stroke's"
    assert server.session.fault is client.session.fault is None


@pytest.mark.long
@pytest.mark.parametrize(("side", "seconds"), STEPS)
def test_a_clock_stepped_while_the_sensor_is_heated_is_safe_and_the_work_resumes(
    session: VirtualSession, side: str, seconds: float
) -> None:
    session.hover()
    session.run(0.1)
    step_clock(session, side, seconds)
    session.until(lambda s: s.both_engaged, RESUMED_S)
    session.resume()
    assert session.remote.server.session.fault is session.operator.client.session.fault is None


@pytest.mark.long
@pytest.mark.parametrize(("side", "seconds"), STEPS)
def test_a_clock_stepped_during_a_partition_lets_the_work_resume(
    working: VirtualSession, side: str, seconds: float
) -> None:
    working.network.impair(cut=True)
    working.run(0.5)
    step_clock(working, side, seconds)
    working.run_coarsely(2.0)
    working.network.heal()
    working.until(lambda s: s.both_engaged, RESUMED_S + GAP_S)
    working.resume()
