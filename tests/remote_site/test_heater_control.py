"""A heater that holds its offset and stops in doubt."""

import pytest

from remote_site.heater_control import HeaterControl, next_offset_k


def plate(control, seconds, lag_s=0.3):
    """A plate of 5.2 K/s at full drive, 2 mW/K to air, read through a lag."""
    true = read = 23.0
    worst = 0.0
    for n in range(round(100 * seconds)):
        drive = control.step(0.01 * n, read, 23.0, False)
        true += 0.01 * (5.2 * drive - 0.03 * (true - 23.0))
        read += 0.01 / lag_s * (true - read)
        worst = max(worst, true)
    return true, worst


@pytest.mark.parametrize("lag_s", [0.2, 0.3, 0.5])
def test_the_plate_reaches_its_offset_without_overshoot(lag_s):
    true, worst = plate(HeaterControl(10.0), 6.0, lag_s)
    assert true == pytest.approx(33.0, abs=0.15)
    assert worst < 33.6


def test_the_heater_is_off_in_contact_and_in_doubt():
    control = HeaterControl()
    assert control.step(0.0, 25.0, 23.0, False) == 1.0
    assert control.step(0.1, 25.0, 23.0, True) == 0.0
    assert control.step(0.2, None, 23.0, False) == 0.0
    assert control.step(0.3, 25.0, None, False) == 0.0
    assert control.step(0.4, 25.0, 23.0, False, age_s=0.2) == 0.0
    assert control.step(0.5, 25.0, 23.0, False, fault="open") == 0.0
    assert control.step(0.6, float("nan"), 23.0, False) == 0.0
    assert control.step(0.7, 42.5, 23.0, False) == 0.0


def test_the_next_offset_never_passes_42_c():
    assert next_offset_k(10.0, 23.0) == 17.0
    assert next_offset_k(17.0, 23.0) == 3.0
    assert next_offset_k(3.0, 23.0) == 10.0
    assert next_offset_k(10.0, 26.0) == 3.0
