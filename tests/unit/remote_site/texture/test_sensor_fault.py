"""Faults of the texture sensor have names, make nothing felt, and end by themselves."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from remote_site.devices.texture_sensor import VOLTS_PER_COUNT
from remote_site.texture.recorded.stroke_playback import Array
from remote_site.texture.sensor_fault import CLIPPED, DISCONNECTED, NOISE_ONLY, SATURATED
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
