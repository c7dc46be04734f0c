"""Faults of a spreading-resistance thermometer."""

from common.wire.messages import ThermalReason
from remote_site.devices.thermal_sensor import ThermometerCheck


def test_implausible_sensors_are_named():
    def last(counts, drive=0.0):
        check = ThermometerCheck()
        return [check.step(0.01 * k, n, drive) for k, n in enumerate(counts)][-1]

    assert last([2000, 2001]) is ThermalReason.NONE
    assert last([0]) is ThermalReason.SENSOR_SHORTED
    assert last([4095]) is ThermalReason.SENSOR_OPEN
    assert last([2000, 2200]) is ThermalReason.SENSOR_JUMPS
    assert last([2000] * 150, drive=1.0) is ThermalReason.SENSOR_FROZEN
    assert last([2000] * 150) is ThermalReason.NONE


def test_a_count_that_returns_after_a_gap_was_not_repeated() -> None:
    """The sensor was unplugged, or the site stood still, and nobody read it meanwhile."""
    check = ThermometerCheck()
    assert check.step(0.0, 2000, 1.0) is ThermalReason.NONE
    for n in range(100):
        assert check.step(5.0 + 0.01 * n, 2000, 1.0) is ThermalReason.NONE
    assert check.step(6.02, 2000, 1.0) is ThermalReason.SENSOR_FROZEN
