"""The testbed in lock step: each site ticks at its own rate, and both act on each other."""

from pathlib import Path

import pytest

from common.config import OperatorConfig, RemoteConfig
from studies.lockstep_session import LockStepSession

pytestmark = pytest.mark.session


def test_each_site_ticks_at_its_own_rate_and_the_session_works(tmp_path: Path) -> None:
    ticks = {"remote": 0, "operator": 0}
    rates = [kind.model_fields["rate_hz"].default for kind in (RemoteConfig, OperatorConfig)]
    with LockStepSession.open(tmp_path) as session:
        session.wait_until_working()
        begin_s = session.now_s()
        while session.now_s() < begin_s + 1.0:
            session.lockstep.step(session.devices)
            for name, site in session.lockstep.due():
                ticks[name] += 1
                site.tick(session.lockstep.now_ns())
        assert set(session.states().values()) == {"engaged"}
    assert list(ticks.values()) == [pytest.approx(rate, abs=1) for rate in rates]
