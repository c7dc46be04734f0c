"""A thermal sensor that comes off its plate heats no patient, and names no material and no temperature."""

import pytest

from common.wire.messages import ThermalReason
from tests.virtual.configurations import FINGER
from tests.virtual.session import VirtualSession

pytestmark = pytest.mark.long


def test_a_loose_sensor_is_in_doubt_until_it_has_passed_its_test(session: VirtualSession) -> None:
    """It comes off before the first heating, which finds it."""
    session.break_device(f"remote: loosen {FINGER} 1")
    session.run(1.0)
    session.until(lambda _: "heater_test" in session.remote.figures()["limited"].get(FINGER, ()), 10.0)
    hottest_c = max(truth.sensor_c for truth in session.truth)
    assert hottest_c < 40.0
    session.resume()
    (touch,) = session.remote.perception.touches.values()
    assert touch.thermal.answer.reason is ThermalReason.SENSOR_FROZEN
    assert touch.thermal.answer.material is None
    assert not session.remote.figures()["fault"]
