"""Slow networks: within the agreed age the work continues, beyond it nothing acts until the delay falls."""

import pytest

from common.limits import AGE_DEFAULT_S, AGE_MAX_S
from tests.virtual.conftest import MakeSession
from tests.virtual.session import Truth

pytestmark = pytest.mark.long

TOO_LONG_S = 0.2


def assert_nothing_acts(truth: list[Truth]) -> None:
    """No output of either site in all this time."""
    for now in truth:
        assert (now.force_n, now.motor_mv, now.peltier, now.heater) == (0.0, 0, 0.0, 0.0), now


@pytest.mark.parametrize(("max_age_s", "delay_s", "jitter_s"), [(AGE_DEFAULT_S, 0.100, 0.040), (AGE_MAX_S, 0.400, 0.0)])
def test_work_continues_with_a_delay_within_the_age(
    make_session: MakeSession, max_age_s: float, delay_s: float, jitter_s: float
) -> None:
    session = make_session(max_age_s=max_age_s, clocks_agree_s=delay_s + jitter_s)
    session.network.impair(delay_s=delay_s, jitter_s=jitter_s)
    session.work()
    ident = session.remote.server.session.ident
    session.run(1.0)
    for now in session.run(2.0):
        assert now.force_n > 0.2, now
        assert now.contact_n > 0.1, now
    assert session.at_work
    assert session.remote.server.session.ident == ident


def test_a_delay_beyond_the_age_is_safe_from_the_beginning_and_in_work_and_work_resumes_when_it_falls(
    make_session: MakeSession,
) -> None:
    session = make_session(clocks_agree_s=AGE_DEFAULT_S)  # the delay falls on one way first
    session.network.impair(delay_s=TOO_LONG_S)
    session.sim_operator.hand.start()
    assert_nothing_acts(session.run_coarsely(5.0))
    session.network.heal()
    session.work()
    session.network.impair(delay_s=TOO_LONG_S)
    session.run(0.3)
    assert_nothing_acts(session.run(0.7) + session.run_coarsely(4.3))
    session.network.heal()
    session.resume()
