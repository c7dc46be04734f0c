"""Both sites in lock step over real lines: each ticks at its own rate, and both act on each other."""

from pathlib import Path

import pytest

from common.config.site_models import OperatorConfig, RemoteConfig
from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.testbed.lockstep import LockStep, SimulatedDevices, sites

pytestmark = pytest.mark.session


def test_each_site_ticks_at_its_own_rate_and_the_session_works(tmp_path: Path) -> None:
    ticks = {"remote": 0, "operator": 0}
    rates = [kind.model_fields["rate_hz"].default for kind in (RemoteConfig, OperatorConfig)]
    configs, lockstep = prepare(DemoOptions(fingers=1), tmp_path), LockStep()
    devices = SimulatedDevices(configs, lockstep.now_s)
    try:
        with sites(lockstep, configs):
            lockstep.engage(devices)
            begin_s = lockstep.time_s
            while lockstep.time_s < begin_s + 1.0:
                lockstep.step(devices)
                for name, site in lockstep.due():
                    ticks[name] += 1
                    site.tick(lockstep.now_ns())
            assert lockstep.remote.server.both_engaged
            assert lockstep.operator.client.both_engaged
    finally:
        devices.close()
    assert list(ticks.values()) == [pytest.approx(rate, abs=1) for rate in rates]
