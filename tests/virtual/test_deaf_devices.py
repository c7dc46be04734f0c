"""Devices that report and do not receive: each is named as missing, and none as soon as it receives again."""

import pytest

from tests.virtual.session import VirtualSession

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
