"""Devices that report and do not receive: each is named as missing, and none as soon as it receives again."""

from itertools import pairwise

import pytest

from common.limits import APPROACH_DOWN_M_S, FORCE_RAMP_UP_N_S, MODULE_TIMEOUT_S
from tests.virtual.session import TICK_S, VirtualSession

pytestmark = pytest.mark.long

DEAF = {
    "operator: deafen index tacttip": "index tacttip: it reports, but receives no commands",
    "operator: deafen can": "exoskeleton: it reports, but its drives stay off",
    "remote: deafen index thermal": "index thermal_sensor: it reports, but receives no commands",
    "remote: deafen can": "telemanipulator: it reports, but receives no set-points",
}


@pytest.mark.parametrize("fault", DEAF)
def test_a_device_that_receives_no_commands_is_named(working: VirtualSession, fault: str) -> None:
    site = working.operator if fault.startswith("operator") else working.remote
    assert site.figures()["missing"] == ""
    working.watch.clear()
    working.break_device(fault)
    working.until(lambda _: site.figures()["missing"] == DEAF[fault], 1.0)
    working.mend_devices()
    working.until(lambda _: site.figures()["missing"] == "", 1.0)


DEAF_S = (MODULE_TIMEOUT_S + 0.05, 0.3, 0.6)
RESOLUTION_N = 0.01
"""Of a force on the exoskeleton's bus."""


@pytest.mark.parametrize("deaf_s", DEAF_S)
def test_an_exoskeleton_that_receives_again_begins_from_zero_force(working: VirtualSession, deaf_s: float) -> None:
    working.watch.clear()
    working.break_device("operator: deafen can")
    working.run(deaf_s)
    assert working.now.force_n < RESOLUTION_N
    working.mend_devices()
    forces = [truth.force_n for truth in working.run(0.2)]
    assert forces[-1] > 0.2
    rise_n = max(after - before for before, after in pairwise(forces))
    assert rise_n <= FORCE_RAMP_UP_N_S * TICK_S + RESOLUTION_N
    assert working.latched == (False, False)


@pytest.mark.parametrize("deaf_s", DEAF_S)
def test_a_telemanipulator_that_receives_again_approaches_slowly(session: VirtualSession, deaf_s: float) -> None:
    """The operator's finger goes down meanwhile."""
    session.run_coarsely(1.5)
    session.until(lambda each: each.both_engaged and each.now.z_m < 0.004, 10.0)
    session.watch.clear()
    session.break_device("remote: deafen can")
    session.run(deaf_s)
    session.mend_devices()
    heights = [truth.z_m for truth in session.run(0.3)]
    fall_m_s = max(before - after for before, after in pairwise(heights)) / TICK_S
    assert fall_m_s <= 1.1 * APPROACH_DOWN_M_S
    assert session.latched == (False, False)
