"""Slow networks: within the agreed age the work continues, beyond it nothing acts until the delay falls."""

from collections.abc import Callable

import pytest

from common.limits import AGE_DEFAULT_S
from tests.virtual.session import Truth, VirtualSession

pytestmark = pytest.mark.long

MakeSession = Callable[..., VirtualSession]


def assert_nothing_acts(truth: list[Truth]) -> None:
    """No output of either site in all this time."""
    for now in truth:
        assert (now.force_n, now.motor_mv, now.peltier, now.heater) == (0.0, 0, 0.0, 0.0), now


def assert_work_continues(session: VirtualSession) -> None:
    """A stroke is felt without a break, and the session stays the same one."""
    session.work()
    ident = session.remote.server.session.ident
    session.run(1.0)
    for now in session.run(2.0):
        assert now.force_n > 0.2, now
        assert now.contact_n > 0.1, now
    assert session.at_work
    session.run(5.0)
    session.work()
    assert session.remote.server.session.ident == ident


@pytest.mark.parametrize(("delay_s", "jitter_s"), [(0.020, 0.010), (0.100, 0.040)])
def test_work_continues_with_a_delay_within_the_age(make_session: MakeSession, delay_s: float, jitter_s: float) -> None:
    session = make_session(clocks_agree_s=delay_s + jitter_s)
    session.network.impair(delay_s=delay_s, jitter_s=jitter_s)
    assert_work_continues(session)


@pytest.mark.parametrize("delay_s", [0.200, 0.400])
def test_nothing_ever_acts_with_a_delay_beyond_the_age_until_it_falls(
    make_session: MakeSession, delay_s: float
) -> None:
    session = make_session(clocks_agree_s=AGE_DEFAULT_S)  # the delay falls on one way first
    session.network.impair(delay_s=delay_s)
    session.sim_operator.hand.start()
    assert_nothing_acts(session.run(10.0))
    session.network.heal()
    session.work()


@pytest.mark.parametrize("delay_s", [0.200, 0.400])
def test_a_delay_that_rises_beyond_the_age_is_safe_and_work_resumes_when_it_falls(
    make_session: MakeSession, delay_s: float
) -> None:
    session = make_session(clocks_agree_s=AGE_DEFAULT_S)
    session.work()
    session.network.impair(delay_s=delay_s)
    session.run(0.3)
    assert_nothing_acts(session.run(8.0))
    session.network.heal()
    session.work()


def test_work_continues_with_a_delay_of_400_ms_where_both_sites_allow_500(make_session: MakeSession) -> None:
    session = make_session(max_age_s=0.5, clocks_agree_s=0.4)
    session.network.impair(delay_s=0.400)
    assert_work_continues(session)
