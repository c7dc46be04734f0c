"""Faults of the texture sensor have names, make nothing felt, and end by themselves."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from remote_site.devices.texture_sensor import VOLTS_PER_COUNT
from remote_site.texture.recorded.stroke_playback import Array
from remote_site.texture.sensor_fault import CLIPPED, DISCONNECTED, NOISE_ONLY, NOISY, SATURATED, TOO_FEW, SensorFault
from remote_site.texture.tip_path import RATE_HZ
from sim_sensors.traces.simulated_stroke import simulate_stroke
from studies.texture.strokes import stroking
from tests.unit.remote_site.simulated_strokes import SIX, drawn, played


def noise(noise_v: float) -> Callable[[Array], Array]:
    return lambda v: np.random.default_rng(1).normal(0.0, noise_v, len(v))


FAULTS: dict[str, tuple[str, Callable[[Array], Array]]] = {
    "saturated": (SATURATED, lambda v: np.full_like(v, 2047 * VOLTS_PER_COUNT)),
    "cut": (DISCONNECTED, np.zeros_like),
    "loose": (NOISE_ONLY, lambda v: np.rint(noise(0.008)(v) / VOLTS_PER_COUNT) * VOLTS_PER_COUNT),
    "finer": (NOISE_ONLY, noise(0.008)),
    "noisy": (NOISE_ONLY, noise(0.05)),
    "noisier": (NOISE_ONLY, noise(0.5)),
    "overdriven": (
        CLIPPED,
        lambda v: np.clip(v + 11.0 * np.sin(np.arange(len(v)) / 20.0), -10.0, 2047 * VOLTS_PER_COUNT),
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_and_nothing_is_felt(fault):
    sound = simulate_stroke("closely_grooved_pvc", 81_000, 60.0, 1.5)
    name, spoil = FAULTS[fault]
    textures = [block.texture for block in stroking(played(replace(sound, pressure_v=spoil(sound.pressure_v))))]
    assert {texture.fault for texture in textures} == {name}
    assert not any(texture.valid or texture.impulses or texture.surface for texture in textures)


@pytest.mark.long
@pytest.mark.parametrize("fault", ["saturated", "cut", "overdriven"])
def test_a_fault_within_a_stroke_ends_with_its_cause(fault):
    trace = simulate_stroke("widely_grooved_pvc", 82_000, 60.0, 1.5, length_m=0.2)
    broken = (trace.time_s > trace.stroke_s[0] + 0.8) & (trace.time_s < trace.stroke_s[0] + 1.3)
    signal = trace.pressure_v.copy()
    name, spoil = FAULTS[fault]
    signal[broken] = spoil(signal[broken])
    blocks = played(replace(trace, pressure_v=signal))
    assert name in {block.texture.fault for block in blocks}
    assert blocks[-1].texture.fault is None
    last = stroking(blocks)[-1].texture
    assert last.valid
    assert last.best == "widely_grooved_pvc"


@pytest.mark.long
@pytest.mark.parametrize("surface", SIX)
def test_a_false_fault_of_a_sensor_ends_with_the_next_contact(surface):
    """A force sensor that is biased for a while before the finger comes down, at once into a stroke."""
    trace = drawn(surface, 86_000)
    came_s = trace.stroke_s[0] + 0.15
    before = np.arange(-0.8, 0.0, 1.0 / RATE_HZ)
    quiet = np.random.default_rng(3).normal(0.0, 0.008, len(before))
    later = trace.time_s >= came_s
    biased_n = np.where((before > -0.5) & (before < -0.25), 1.5, 0.0)
    both = replace(
        trace,
        time_s=np.concatenate([came_s + before, trace.time_s[later]]),
        pressure_v=np.concatenate([quiet, trace.pressure_v[later]]),
        force_n=np.concatenate([biased_n, trace.force_n[later]]),
        speed_mm_s=np.concatenate([np.zeros(len(before)), trace.speed_mm_s[later]]),
    )
    blocks = played(both)
    assert NOISE_ONLY in {block.texture.fault for block in blocks}
    last = stroking(blocks)[-1].texture
    assert last.fault is None
    assert last.valid


@pytest.mark.long
@pytest.mark.parametrize("late_s", [-0.1, -0.05, 0.05, 0.1])
def test_a_sound_sensor_has_no_fault_when_force_and_texture_come_apart(late_s):
    trace = drawn("closely_grooved_pvc", 85_000)
    apart = replace(trace, pressure_v=np.roll(trace.pressure_v, round(late_s * RATE_HZ)))
    assert {block.texture.fault for block in played(apart)} == {None}


def named(rate_hz: float, late_s: float, seconds: float = 4.0) -> list[str | None]:
    """Fault after each block of a sensor of this rate, which a loop reads up to `late_s` late, at most four at once."""
    watch, chance, found, read, t_s = SensorFault(10), np.random.default_rng(1), [], 0, 0.0
    while t_s < seconds:
        t_s += 0.002 + chance.uniform(0.0, late_s)
        ready = min(int(t_s * rate_hz / 10.0) - read, 4)
        ends_s = [t_s - left * 10.0 / RATE_HZ for left in range(ready - 1, -1, -1)]
        found += [watch.step(end_s, [0.01, -0.01] * 5, 0.0, False) for end_s in ends_s]
        read += ready
    return found


@pytest.mark.parametrize("late_s", [0.0003, 0.010])
def test_a_sensor_slower_than_firmware_may_be_is_named_and_a_late_loop_is_not(late_s):
    assert set(named(0.955 * RATE_HZ, late_s)) == {None}
    for slow_hz in (0.5 * RATE_HZ, 0.85 * RATE_HZ):
        found = named(slow_hz, late_s)
        assert found[-1] == TOO_FEW
        assert set(found[found.index(TOO_FEW) :]) == {TOO_FEW}


def test_a_pause_is_not_too_few_samples():
    watch, t_s, found = SensorFault(10), 0.0, set()
    for block in range(2000):
        t_s += 0.105 if block % 100 == 0 else 0.005
        found.add(watch.step(t_s, [0.01, -0.01] * 5, 0.0, False))
    assert found == {None}


FREE_TIME_S = np.arange(1, 2001) / RATE_HZ
"""Times of a second without contact."""


def without_contact(added_v: Array, touched_s: float = 1.0) -> str | None:
    """Fault at the end of a touch, after a second without contact in which this is added to the noise."""
    watch, signal_v = SensorFault(10, noise_v=0.008), noise(0.008)(FREE_TIME_S) + added_v
    for block, end_s in enumerate(FREE_TIME_S[9::10].tolist()):
        watch.step(end_s, signal_v[10 * block : 10 * block + 10].tolist(), 0.0, True, True)
    for block in range(1, round(touched_s * RATE_HZ / 10) + 1):
        watch.step(1.0 + 0.005 * block, (0.3 + noise(0.008)(np.zeros(10))).tolist(), 1.0, False)
    return watch.fault


@pytest.mark.parametrize("hum_hz", [50.0, 60.0])
def test_hum_without_contact_is_named_in_the_next_touch(hum_hz):
    hum = np.sin(2.0 * np.pi * hum_hz * FREE_TIME_S)
    assert without_contact(0.05 * hum) == NOISY
    assert without_contact(0.01 * hum) is None


def test_drift_a_knock_and_speech_are_no_hum():
    knock = np.exp(-np.maximum(FREE_TIME_S - 0.9, 0.0) / 0.05) * (FREE_TIME_S > 0.9)
    assert without_contact(0.5 * FREE_TIME_S) is None
    assert without_contact(knock * np.sin(2.0 * np.pi * 25.0 * FREE_TIME_S)) is None
    assert without_contact(0.1 * np.sin(2.0 * np.pi * 230.0 * FREE_TIME_S)) is None
    assert without_contact(noise(0.02)(FREE_TIME_S)) is None


def test_hum_that_is_over_is_no_fault_after_the_next_time_without_contact():
    watch = SensorFault(10, noise_v=0.008)
    faults = []
    for second, hum_v in enumerate((0.1, 0.0)):
        signal_v = noise(0.008)(FREE_TIME_S) + hum_v * np.sin(2.0 * np.pi * 50.0 * FREE_TIME_S)
        for block, end_s in enumerate((second + FREE_TIME_S[9::10]).tolist()):
            watch.step(end_s, signal_v[10 * block : 10 * block + 10].tolist(), 0.0, True, True)
        faults.append(watch.fault)
    assert faults == [NOISY, None]


def test_hum_over_a_surface_gives_no_roughness():
    sound = drawn("plain_pvc", 87_000)
    before = np.arange(-1.0, 0.0, 1.0 / RATE_HZ)
    time_s = np.concatenate([before, sound.time_s])
    hum = 0.1 * np.sin(2.0 * np.pi * 50.0 * time_s)
    quiet = np.zeros(len(before))
    noisy = replace(
        sound,
        time_s=time_s,
        pressure_v=np.concatenate([noise(0.008)(before), sound.pressure_v]) + hum,
        force_n=np.concatenate([quiet, sound.force_n]),
        speed_mm_s=np.concatenate([quiet, sound.speed_mm_s]),
    )
    textures = [block.texture for block in stroking(played(noisy))]
    assert {texture.fault for texture in textures} == {NOISY}
    assert not any(texture.valid or texture.impulses for texture in textures)
