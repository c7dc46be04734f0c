"""How late pictures come by the camera's own time stamps."""

import pytest

from remote_site.camera.picture_lag import DRIFT, PictureLag

RATE_HZ = 25.0


def test_pictures_that_come_at_their_rate_have_no_lag() -> None:
    lag = PictureLag()
    assert [lag.take(1000.0 + n / RATE_HZ, 7.0 + n / RATE_HZ) for n in range(500)] == pytest.approx(
        [0.0] * 500, abs=1e-9
    )


def test_a_machine_that_decodes_too_slowly_shows_ever_older_pictures() -> None:
    lag = PictureLag()
    lags_s = [lag.take(1.5 * n / RATE_HZ, n / RATE_HZ) for n in range(500)]
    assert lags_s[-1] == pytest.approx(0.5 * 499 / RATE_HZ, rel=0.01)


def test_pictures_that_waited_in_the_network_are_as_old_as_they_waited() -> None:
    lag = PictureLag()
    for n in range(100):
        lag.take(n / RATE_HZ, n / RATE_HZ)
    stalled_s = 103.0 / RATE_HZ + 2.0
    assert lag.take(stalled_s, 101.0 / RATE_HZ) == pytest.approx(2.0 + 2.0 / RATE_HZ, abs=0.01)
    assert lag.take(stalled_s + 0.01, stalled_s) == pytest.approx(0.01, abs=0.005)


@pytest.mark.parametrize("drift", [-100e-6, 100e-6])
def test_the_drift_of_the_cameras_clock_is_no_lag(drift: float) -> None:
    lag = PictureLag()
    hours_s = [lag.take(0.04 * n * (1.0 + drift), 0.04 * n) for n in range(90_000)]
    assert max(hours_s) < DRIFT


@pytest.mark.parametrize("jump_s", [-1000.0, 1000.0])
def test_time_stamps_that_begin_again_begin_a_new_comparison(jump_s: float) -> None:
    lag = PictureLag()
    for n in range(100):
        lag.take(n / RATE_HZ, 2000.0 + n / RATE_HZ)
    lags_s = [lag.take(4.0 + n / RATE_HZ, 2004.0 + jump_s + n / RATE_HZ) for n in range(100)]
    assert lags_s == pytest.approx([0.0] * 100, abs=1e-9)
    assert lag.take(9.0, 2008.0 + jump_s) == pytest.approx(1.0, abs=0.01)
