"""The speed limit of a set-point that was let go."""

import math

import pytest

from remote_site.safety.approach_limiter import MET_M, WIDEN_M_S2, ApproachLimiter


def test_the_approach_is_slow_until_it_has_met_and_then_reaches_full_speed() -> None:
    approach = ApproachLimiter(0.1, 0.1 + 1.5 * WIDEN_M_S2)

    def state() -> tuple[float, bool, bool]:
        return approach.limit_m_s, approach.met, approach.settled

    for _ in range(2):
        assert state() == (0.1, False, False)
        approach.step(1.0, math.nextafter(MET_M, 1.0))
        assert state() == (0.1, False, False)
        approach.step(1.0, MET_M)
        assert state() == (pytest.approx(0.1 + WIDEN_M_S2), True, False)
        approach.step(1.0, 1.0)  # it has met: how far it stays behind no longer counts
        assert state() == (0.1 + 1.5 * WIDEN_M_S2, True, True)
        approach.let_go()
