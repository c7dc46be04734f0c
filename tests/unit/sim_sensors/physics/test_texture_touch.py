import numpy as np
import pytest

from common.scenes.surfaces import surface_kind
from sim_sensors.physics.surface import make_profile, relief_of
from sim_sensors.physics.texture_touch import (
    NOISE_V,
    RELIEF_PER_M,
    VOLTS_PER_COUNT,
    TextureTouch,
    compliance_share,
)

TICK_S = 0.002
LENGTH_M = 0.1


def stroke(name, *, speed_m_s=0.06, force_n=1.2, seconds=1.5, take_every=5, seed=0):
    """Volts of one finger that is pressed on at 0.1 s and slides from 0.3 s on; and the groove centres."""
    profile = make_profile(relief_of(name), LENGTH_M, np.random.default_rng(seed))
    touch = TextureTouch(1, profile.height_m[0], profile.slope[0], np.random.default_rng(seed + 1))
    gain = RELIEF_PER_M * compliance_share(surface_kind(name).stiffness_n_m)
    taken = []
    for tick in range(1, round(seconds / TICK_S) + 1):
        now = tick * TICK_S
        pressed = force_n if now > 0.1 else 0.0
        x = max(0.0, now - 0.3) * speed_m_s
        touch.step(now, x, force_n=[pressed], gain=[gain], track=[0], origin_m=[0.0])
        if tick % take_every == 0:
            taken.append(touch.take_counts()[0])
    taken.append(touch.take_counts()[0])
    return np.concatenate(taken) * VOLTS_PER_COUNT, profile.grooves_m


def level(name, **how):
    """Mean rectified signal of an even stroke, V."""
    return np.abs(stroke(name, **how)[0][1200:]).mean()


def test_two_thousand_samples_a_second_however_often_they_are_taken():
    often, _ = stroke("sandpaper", take_every=1)
    seldom, _ = stroke("sandpaper", take_every=10_000)
    assert often.size == 3000
    assert np.array_equal(often, seldom)


def test_surfaces_differ_as_decided():
    assert 0.006 < level("plain_pvc") < 0.020
    assert 0.15 < level("sandpaper") < 0.40
    assert level("foam") < 0.05
    assert level("sandpaper") > 8 * level("foam")


def test_a_resting_finger_gives_noise_only():
    rest, _ = stroke("sandpaper", speed_m_s=0.0)
    assert rest[2000:].std() == pytest.approx(np.hypot(NOISE_V, VOLTS_PER_COUNT / np.sqrt(12.0)), rel=0.1)
    assert abs(rest[2000:].mean()) < 0.002


def test_roughness_grows_with_force_and_with_speed():
    assert level("sandpaper", force_n=2.4) == pytest.approx(2.0 * level("sandpaper"), rel=0.05)
    slow, fast = level("sandpaper", speed_m_s=0.02), level("sandpaper", speed_m_s=0.06)
    assert 1.05 * slow < fast < 2.0 * slow


def test_pressing_shows_as_a_transient_without_dc():
    volts, _ = stroke("plain_pvc", speed_m_s=0.0)
    at = round(0.1 * 2000)
    assert volts[at : at + 20].max() == pytest.approx(1.2, abs=0.12)
    assert abs(volts[at + 106 + 4]) == pytest.approx(1.2 * np.exp(-1.0), abs=0.06)  # 53 ms: the leaky integrator
    assert np.abs(volts[at + 800 :]).max() < 0.05


def test_every_groove_gives_one_pulse_of_a_few_milliseconds():
    volts, grooves = stroke("closely_grooved_pvc", seconds=1.5)
    down = volts[600:] < -0.3
    starts = np.flatnonzero(down[1:] & ~down[:-1])
    crossed = sum(groove < 1.2 * 0.06 for groove in grooves)
    assert abs(len(starts) - crossed) <= 1
    width_ms = down.sum() / len(starts) / 2.0
    assert 1.0 < width_ms < 8.0
    assert 0.5 < -volts[600:].min() < 1.5


def test_overload_clips_at_the_limits_of_the_converter():
    volts, _ = stroke("plain_pvc", force_n=40.0, speed_m_s=0.0, seconds=0.3)
    assert volts.max() == pytest.approx(2047 * VOLTS_PER_COUNT)


def test_nothing_to_take_before_the_first_sample():
    touch = TextureTouch(5, np.zeros(10, np.float32), np.zeros(10, np.float32), np.random.default_rng(0))
    assert touch.take_counts().shape == (5, 0)


def test_soft_objects_give_way():
    assert compliance_share(400.0) < 0.3
    assert compliance_share(4000.0) == pytest.approx(0.8)
