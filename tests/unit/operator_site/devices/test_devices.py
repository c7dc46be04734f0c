"""Forces act as long as the exoskeleton reports that its drives are on."""

import math
from types import SimpleNamespace

import pytest

from common.fingers import FINGERS
from common.limits import GAP_S
from operator_site.devices.devices import OperatorDevices
from operator_site.devices.exoskeleton import Pushing

NOW_S, NO_FORCE = 16.0, (0.0,) * len(FINGERS)


@pytest.mark.parametrize(
    ("pushing", "pushes"),
    [
        (Pushing(NO_FORCE, True, NOW_S), True),
        (Pushing(NO_FORCE, False, NOW_S), False),
        (Pushing(NO_FORCE, True, NOW_S - GAP_S + 0.001), True),
        (Pushing(NO_FORCE, True, NOW_S - GAP_S - 0.001), False),
        (Pushing(NO_FORCE, True, -math.inf), False),
    ],
)
def test_it_pushes_by_a_recent_report_of_drives_that_are_on(pushing: Pushing, pushes: bool) -> None:
    devices = SimpleNamespace(exoskeleton=SimpleNamespace(pushing=pushing), tick=SimpleNamespace(began_s=NOW_S))
    assert OperatorDevices.pushes.fget(devices) is pushes
