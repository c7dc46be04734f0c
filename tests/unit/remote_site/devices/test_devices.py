"""The telemanipulator follows as long as it reports that set-points of both kinds reach it."""

import math
from types import SimpleNamespace

import pytest

from common.limits import GAP_S
from remote_site.devices.devices import RemoteDevices
from remote_site.devices.telemanipulator import Following

NOW_S = 16.0


@pytest.mark.parametrize(
    ("following", "follows"),
    [
        (Following(False, True, True, NOW_S), True),
        (Following(True, True, True, NOW_S), True),
        (Following(False, False, True, NOW_S), False),
        (Following(False, True, False, NOW_S), False),
        (Following(False, True, True, NOW_S - GAP_S + 0.001), True),
        (Following(False, True, True, NOW_S - GAP_S - 0.001), False),
        (Following(False, True, True, -math.inf), False),
    ],
)
def test_it_follows_by_a_recent_report_that_both_kinds_arrive(following: Following, follows: bool) -> None:
    devices = SimpleNamespace(telemanipulator=SimpleNamespace(following=following), tick=SimpleNamespace(began_s=NOW_S))
    assert RemoteDevices.follows.fget(devices) is follows
