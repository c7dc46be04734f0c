"""Spatial periods from the spectrum of a stroke: found far within its resolution, with an honest deviation, or not."""

import numpy as np
import pytest

from remote_site.texture.recorded.identify_texture import identify_stroke, identify_texture
from remote_site.texture.recorded.spatial_period import spatial_period
from remote_site.traces.trace_files import StrokeTrace

LENGTH_M = 0.150


def stroke(n, period_mm, noise, seed, arm=0.0, shape=np.sin):
    """Path and one signal: a pattern, the arm's swing of 20 mm, and noise."""
    chance = np.random.default_rng(seed)
    path_m = np.linspace(0.0, LENGTH_M, n) + chance.uniform(-0.2, 0.2, n) * LENGTH_M / n
    pattern = shape(2.0 * np.pi * path_m / (1e-3 * period_mm) + chance.uniform(0.0, 6.0))
    swing = arm * np.sin(2.0 * np.pi * path_m / 0.020 + chance.uniform(0.0, 6.0))
    return path_m, (pattern + swing + noise * chance.normal(size=n))[:, None]


def found_mm(path_m, signals):
    found = spatial_period(path_m, signals)
    return None if found is None else 1e3 * found[0].period_m


def grooves(phase):
    return np.sign(np.sin(phase))


def ridges(phase):
    return np.exp(-0.5 * (((phase / (2.0 * np.pi)) % 1.0 - 0.5) / 0.06) ** 2)


@pytest.mark.parametrize("shape", [np.sin, grooves, ridges])
@pytest.mark.parametrize("n", [180, 540, 2000])
def test_the_fundamental_is_found(shape, n):
    for seed in range(10):
        assert found_mm(*stroke(n, 7.0, 0.2, seed, shape=shape)) == pytest.approx(7.0, rel=0.01)


@pytest.mark.parametrize("period_mm", [2.3, 4.0, 6.0])
def test_a_larger_swing_of_the_arm_is_not_taken_for_the_pattern(period_mm):
    for seed in range(10):
        assert found_mm(*stroke(540, period_mm, 0.3, seed, arm=2.5)) == pytest.approx(period_mm, rel=0.01)


def test_a_period_far_finer_than_the_spectrum_s_resolution():
    """The nearest frequencies of the spectrum itself would be off by up to 6 %."""
    for period_mm in np.linspace(15.0, 20.0, 11):
        assert found_mm(*stroke(540, period_mm, 0.3, 1)) == pytest.approx(period_mm, rel=0.01)


def walk(chance, n):
    return np.cumsum(chance.normal(size=n))


def white(chance, n):
    return chance.normal(size=n)


def arbitrary(chance, n):
    """Grooves at distances of 2 to 10 mm."""
    at_mm = np.cumsum(chance.uniform(2.0, 10.0, 80))
    x_mm = np.linspace(0.0, 1e3 * LENGTH_M, n)
    return -np.exp(-0.5 * ((x_mm[:, None] - at_mm) / 0.7) ** 2).sum(axis=1) + 0.05 * chance.normal(size=n)


@pytest.mark.long
@pytest.mark.parametrize("surface", [white, walk, arbitrary])
@pytest.mark.parametrize("n", [180, 540])
def test_no_pattern_no_period(surface, n):
    chance = np.random.default_rng(2)
    path_m = np.linspace(0.0, LENGTH_M, n)
    found = [spatial_period(path_m, surface(chance, n)[:, None]) for _ in range(60)]
    assert sum(one is not None for one in found) <= 2


def test_a_flat_or_short_signal_has_no_period():
    assert spatial_period(np.linspace(0.0, 0.1, 300), np.full((300, 2), 7.0)) is None
    assert spatial_period(np.linspace(0.0, 0.1, 10), np.arange(10.0)[:, None]) is None


@pytest.mark.long
def test_the_deviation_covers_the_error():
    """Of a pattern that leads and lags by a quarter of a millimetre along the stroke, as on a soft sensor."""
    chance = np.random.default_rng(3)
    errors = []
    for seed in range(60):
        path_m, _ = stroke(540, 4.0, 0.0, seed)
        lean_m = 0.25e-3 * np.interp(path_m, np.linspace(0.0, LENGTH_M, 6), chance.normal(size=6))
        signal = np.sin(2.0 * np.pi * (path_m + lean_m) / 0.004) + 0.5 * chance.normal(size=540)
        found = spatial_period(path_m, signal[:, None])
        assert found is not None
        errors.append((found[0].period_m - 0.004) / found[0].period_sd_m)
    assert 0.5 < np.std(errors) < 1.3
    assert np.max(np.abs(errors)) < 3.5


def test_of_several_signals_the_clearest_is_named():
    path_m, clear = stroke(540, 4.0, 0.2, 4)
    others = [stroke(540, 4.0, 6.0, seed)[1] for seed in (5, 6)]
    found = spatial_period(path_m, np.hstack([others[0], clear, others[1], np.zeros_like(clear)]))
    assert found is not None
    assert found[1] == 1


PLACES_MM = np.linspace(0.0, 14.0, 16)


def shaken(seed, period_mm=4.0, depth=0.02, shake=0.03, tilt=0.0, speed_mm_s=5.0, hz=2.2):
    """Path and 16 signals of a sensor that passes a pattern while it shakes with more slope than the pattern."""
    chance = np.random.default_rng(seed)
    t = np.arange(0.0, 1e3 * LENGTH_M / speed_mm_s, 1.0 / 35.7)
    x_mm = speed_mm_s * t
    load = chance.uniform(60.0, 200.0, 16)
    pattern = depth * np.sin(2.0 * np.pi * (x_mm[:, None] - PLACES_MM) / period_mm)
    motion = np.sin(2.0 * np.pi * hz * t + chance.uniform(0.0, 6.0))[:, None]
    way = np.where(PLACES_MM < 7.0, 1.0 - tilt, 1.0) * chance.normal(1.0, 0.1, 16)
    noise = 0.005 * chance.normal(size=(len(t), 16))
    return 1e-3 * x_mm, load * (1.0 + pattern + shake * way * motion + noise)


@pytest.mark.long
@pytest.mark.parametrize("tilt", [0.0, 2.0])
@pytest.mark.parametrize("shake", [0.02, 0.05])
def test_a_motion_of_the_whole_sensor_is_not_taken_for_the_pattern(tilt, shake):
    """It heaves, or tilts so that half of the signals oppose the others; alone it would be a pattern of 2.27 mm."""
    for seed in range(5):
        assert found_mm(*shaken(seed, shake=shake, tilt=tilt)) == pytest.approx(4.0, rel=0.01)


@pytest.mark.long
def test_a_motion_of_half_the_frequency_is_not_taken_for_the_fundamental():
    """At 20 mm/s a motion of 2.5 Hz is a line of 8 mm."""
    for seed in range(5):
        assert found_mm(*shaken(seed, speed_mm_s=20.0, hz=2.5)) == pytest.approx(4.0, rel=0.01)


def test_the_motion_is_recognised_for_the_mean_of_the_signals_too():
    for seed in range(5):
        path_m, signals = shaken(seed)
        found = spatial_period(path_m, signals.mean(axis=1, keepdims=True), signals)
        assert found is not None
        assert 1e3 * found[0].period_m == pytest.approx(4.0, rel=0.01)


def test_a_motion_alone_has_no_period():
    for seed in range(5):
        path_m, signals = shaken(seed, depth=0.0)
        assert spatial_period(path_m, signals) is None
        assert spatial_period(path_m, signals.mean(axis=1, keepdims=True), signals) is None


@pytest.mark.long
def test_a_motion_at_the_frequency_of_the_pattern_leaves_it_its_period():
    """At 10 mm/s a pattern of 4 mm comes at 2.5 Hz."""
    for seed in range(5):
        path_m, signals = shaken(seed, depth=0.03, shake=0.02, speed_mm_s=10.0, hz=2.5)
        swing = 6.0 * np.sin(2.0 * np.pi * (path_m[:, None] - 1e-3 * PLACES_MM) / 0.020)
        assert found_mm(path_m, signals + swing) == pytest.approx(4.0, rel=0.01)


def test_the_deviation_grows_with_few_periods():
    """A slow swing of nearly the same wavelength moves the line; the stroke alone does not show it."""
    few, many = (spatial_period(*stroke(540, period_mm, 0.1, 1))[0] for period_mm in (20.0, 4.0))
    assert few.period_sd_m / few.period_m > 2.0 * many.period_sd_m / many.period_m
    assert few.period_sd_m / few.period_m > 0.05 / (LENGTH_M / 0.020)


def write(path, t, signal, speed=None):
    columns = [t, signal] if speed is None else [t, signal, speed]
    header = "time_s,taxel1" if speed is None else "time_s,taxel1,speed_mm_s"
    rows = (",".join(f"{value:.4f}" for value in row) for row in zip(*columns, strict=True))
    path.write_text(header + "\n" + "\n".join(rows) + "\n")


@pytest.mark.parametrize("rate_hz", [35.7, 200.0])
def test_the_period_scales_with_a_wrong_speed(tmp_path, rate_hz):
    t = np.arange(0.0, 12.0, 1.0 / rate_hz)
    noise = np.random.default_rng(7).normal(size=len(t))
    write(tmp_path / "s.csv", t, 20.0 * np.sin(np.pi * t) + 10.0 * np.sin(5.0 * np.pi * t) + 2.0 * noise)
    for wrong in (0.8, 1.0, 1.2):
        (line,) = identify_texture([tmp_path / "s.csv"], signal="taxel1", speed_mm_s=10.0 * wrong)
        assert line["period_mm"] == pytest.approx(4.0 * wrong, rel=0.005)
        assert 0.0 < line["period_sd_mm"] < 0.03


def test_the_deviation_of_the_speed_widens_that_of_the_period(tmp_path):
    t = np.arange(0.0, 12.0, 1.0 / 35.7)
    write(tmp_path / "s.csv", t, 20.0 * np.sin(5.0 * np.pi * t) + np.random.default_rng(7).normal(size=len(t)))
    sds_mm = []
    for speed_sd_mm_s in (0.0, 0.2):
        (line,) = identify_texture([tmp_path / "s.csv"], signal="taxel1", speed_mm_s=10.0, speed_sd_mm_s=speed_sd_mm_s)
        sds_mm.append(line["period_sd_mm"])
    assert sds_mm[1] == pytest.approx(np.hypot(sds_mm[0], 0.02 * 4.0), abs=0.002)
    with pytest.raises(ValueError, match="--speed-sd"):
        list(identify_texture([tmp_path / "s.csv"], signal="taxel1", speed_mm_s=10.0, speed_sd_mm_s=-1.0))


@pytest.mark.parametrize("course", [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 0.0)])
def test_an_error_of_the_speed_counts_beside_that_of_the_motion(tmp_path, course):
    t = np.arange(0.0, 24.0, 1.0 / 35.7)
    speed = 10.0 * np.where(t < 12.0, *course)
    x = np.cumsum(np.abs(speed)) / 35.7
    write(tmp_path / "s.csv", t, 20.0 * np.sin(np.pi * x / 2.0) + np.random.default_rng(7).normal(size=len(t)), speed)
    (exact,) = identify_texture([tmp_path / "s.csv"], signal="taxel1")
    (line,) = identify_texture([tmp_path / "s.csv"], signal="taxel1", speed_sd_mm_s=0.2)
    assert line["period_sd_mm"] == pytest.approx(np.hypot(exact["period_sd_mm"], 0.02 * 4.0), abs=0.003)


def test_the_speed_column_gives_the_path_with_its_rests_and_ramps(tmp_path):
    t = np.arange(0.0, 20.0, 0.028)
    speed = 12.0 * np.interp(t, [0.0, 2.0, 5.0, 14.0, 16.0, 20.0], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    x = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t))))
    noise = np.random.default_rng(8).normal(size=len(t))
    write(tmp_path / "s.csv", t, 100.0 + 10.0 * np.sin(2.0 * np.pi * x / 4.0) + noise, speed)
    (line,) = identify_texture([tmp_path / "s.csv"], signal="taxel1")
    assert line["period_mm"] == pytest.approx(4.0, rel=0.005)


@pytest.mark.parametrize("length_m", [0.03, 0.05, 0.083])
@pytest.mark.parametrize("ways", [1, 2, 3, 5])
def test_turns_of_a_slow_stroke_do_not_change_its_period(length_m, ways):
    speed_m_s, rng = 0.02, np.random.default_rng(ways)
    time_s = np.arange(0.0, ways * length_m / speed_m_s, 1.0 / 35.7)
    speed = speed_m_s * np.where(time_s * speed_m_s / length_m % 2.0 < 1.0, 1.0, -1.0)
    places_m = np.cumsum(speed)[:, None] / 35.7 + 0.8e-3 * np.arange(8)
    signals = 100.0 + np.sin(2.0 * np.pi * places_m / 0.004) + 0.1 * rng.normal(size=places_m.shape)
    names = tuple(f"taxel{number}" for number in range(8))
    (answer,) = identify_stroke(StrokeTrace(time_s, signals, None, speed, names))
    assert answer["period_mm"] is not None
    assert abs(answer["period_mm"] - 4.0) < 3.0 * answer["period_sd_mm"] < 0.2
