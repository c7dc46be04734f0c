"""One finger's texture on simulated strokes: roughness, grooves, surface, change; and in pieces of any size."""

import numpy as np
import pytest

from common.wire.messages import ExplorationMode
from remote_site.texture.groove_detector import Impulse
from remote_site.texture.groove_period import GroovePeriod
from remote_site.texture.recorded.stroke_playback import Array, felt
from remote_site.texture.texture_identification import TextureIdentification, TextureReading
from remote_site.texture.tip_path import RATE_HZ
from sim_sensors.traces.simulated_stroke import simulate_stroke
from studies.texture.strokes import stroking
from tests.unit.remote_site.shipped_tables import SURFACES
from tests.unit.remote_site.simulated_strokes import SIX, counted, drawn, even, held_values, modes_of, played


@pytest.mark.long
@pytest.mark.parametrize("surface", SIX)
def test_a_surface_and_its_roughness_are_the_same_for_any_stroke_and_a_sound_sensor_has_no_fault(surface):
    roughness = []
    for seed in range(71_000, 71_005):
        blocks = played(drawn(surface, seed))
        assert {block.texture.fault for block in blocks} == {None}
        last = stroking(blocks)[-1].texture
        assert last.best == surface
        roughness.append(last.roughness_v)
    assert np.std(roughness) / np.mean(roughness) < 0.15


@pytest.mark.long
@pytest.mark.parametrize("surface", ["closely_grooved_pvc", "widely_grooved_pvc", "arbitrarily_grooved_pvc"])
def test_grooves_are_neither_missed_nor_invented(surface):
    for seed in (72_000, 72_001):
        trace = drawn(surface, seed)
        found = counted(trace, played(trace))
        assert found.crossed > 0
        assert (found.missed, found.invented) == (0, 0)


@pytest.mark.long
@pytest.mark.parametrize("surface", ["foam", "plain_pvc", "sandpaper", "skin", "lesion", "nodule", "pine"])
def test_roughness_is_no_groove(surface):
    trace = simulate_stroke(surface, 73_000, 60.0, 1.5)
    assert counted(trace, played(trace)).invented == 0


def changed_after_s(trace, blocks):
    """From the border between two surfaces to each moment from which another surface was felt."""
    return [block.texture.changed_s - trace.border_s for block in blocks if block.texture.changed_s is not None]


@pytest.mark.long
def test_a_stroke_over_skin_into_a_lesion_and_the_other_way_has_an_edge_and_no_grooves():
    for before, after in (("skin", "lesion"), ("lesion", "skin")):
        trace = simulate_stroke(before, 74_000, 60.0, 1.5, length_m=0.1, then=after)
        blocks = played(trace)
        assert counted(trace, blocks).invented <= 3
        (seen_s,) = changed_after_s(trace, blocks)
        assert 0.0 < seen_s < 0.3


@pytest.mark.long
@pytest.mark.parametrize("pair", [("plain_pvc", "widely_grooved_pvc"), ("sandpaper", "foam"), ("foam", "sandpaper")])
def test_a_change_of_surface_is_seen_once_within_50_mm(pair):
    before, after = pair
    trace = simulate_stroke(before, 75_000, 80.0, 2.0, length_m=0.14, then=after)
    blocks = played(trace)
    (seen_s,) = changed_after_s(trace, blocks)
    assert 0.0 < seen_s < 0.05 / 0.08
    assert stroking(blocks)[-1].texture.surface == after


def read(
    time_s: Array, signal_v: Array, force_n: Array, speed_m_s: Array, modes: list[ExplorationMode], size: int
) -> tuple[list[Impulse], TextureReading]:
    """All impulses and the last reading of a stroke that comes in pieces of `size` samples."""
    identification, impulses = TextureIdentification(SURFACES), []
    for first in range(0, len(time_s), size):
        part = slice(first, first + size)
        reading = identification.step(
            float(time_s[part][-1]), signal_v[part], force_n[part].tolist(), speed_m_s[part].tolist(), modes[part]
        )
        impulses += reading.impulses
    return impulses, reading


@pytest.mark.long
def test_pieces_of_any_size_give_the_same():
    trace = simulate_stroke("arbitrarily_grooved_pvc", 76_000, 90.0, 1.0)
    whole = len(trace.time_s) // 200 * 200
    columns = (trace.time_s, trace.pressure_v, trace.force_n, 1e-3 * trace.speed_mm_s, modes_of(trace))
    found = []
    for size in (1, 7, 200):
        impulses, last = read(*(column[:whole] for column in columns), size)
        found.append((impulses, last.roughness_v, last.probability, last.surface))
    assert found[0] == found[1] == found[2]
    assert len(found[0][0]) > 5


@pytest.mark.long
def test_an_hour_of_stroking_takes_no_more_memory_than_a_minute():
    trace = simulate_stroke("closely_grooved_pvc", 77_000, 60.0, 1.0)
    moving = (trace.time_s > trace.stroke_s[0] + 0.1) & (trace.time_s < trace.stroke_s[1] - 0.1)
    signal = trace.pressure_v[moving][:2000]
    identification, sizes = TextureIdentification(SURFACES), []
    for second in range(40):
        identification.step(float(second + 1), signal, 1.0, 0.06, ExplorationMode.STROKING)
        sizes.append(held_values(identification))
    assert max(sizes[20:]) <= max(sizes[:20])


@pytest.mark.long
@pytest.mark.parametrize("factor", [0.8, 1.2])
def test_a_wrong_speed_makes_the_period_wrong_by_its_factor_and_the_grooves_no_less_regular(factor):
    trace = simulate_stroke("closely_grooved_pvc", 78_000, 50.0, 1.2)
    assert period_of(even(trace, factor)).period_m == pytest.approx(factor * 0.002, rel=0.01)
    assert not period_of(even(trace, factor)).irregular


@pytest.mark.long
def test_a_large_swing_of_the_arm_is_not_mistaken_for_the_pattern():
    stroke = even(simulate_stroke("widely_grooved_pvc", 79_000, 50.0, 1.2, length_m=0.12))
    way_m = np.cumsum(stroke.speed_m_s) / 2000.0
    stroke.signal_v[:] += 3.0 * np.sin(2.0 * np.pi * way_m / 0.020)  # grooves have 1 V
    assert period_of(stroke).period_m == pytest.approx(0.008, rel=0.01)


def period_of(stroke):
    period = GroovePeriod()
    for block in felt(stroke, SURFACES):
        for impulse in block.texture.impulses:
            period.groove(impulse.place_m, (impulse.place_m, 0.0))
    return period.estimate()


def test_a_turn_of_the_hand_is_no_groove():
    """There and back over plain PVC, through rest: the way folds, and nothing is invented where it does."""
    trace = simulate_stroke("plain_pvc", 80_000, 60.0, 1.5)
    moving = (trace.time_s > trace.stroke_s[0]) & (trace.time_s < trace.stroke_s[1])
    signal, speed = trace.pressure_v[moving], 1e-3 * trace.speed_mm_s[moving]
    both = np.concatenate((signal, signal[::-1]))
    turn = np.concatenate((speed, speed[::-1])) * np.minimum(1.0, np.abs(np.arange(2 * len(speed)) - len(speed)) / 60.0)
    time_s = np.arange(1, 1 + len(both)) / RATE_HZ
    modes = [ExplorationMode.STROKING] * len(both)
    assert read(time_s, both, np.full(len(both), 1.5), turn, modes, 10)[0] == []


def test_a_finger_that_jumps_over_the_border_has_come_to_another_surface():
    """It presses so lightly on plain PVC that it loses contact for a moment where the soft foam begins."""
    trace = simulate_stroke("plain_pvc", 91_000, 100.0, 1.0, length_m=0.14, then="foam")
    blocks = played(trace)
    assert any(block.mode is ExplorationMode.FREE for block in blocks if 1.2 < block.end_s < 2.2)
    (seen_s,) = changed_after_s(trace, blocks)
    assert 0.0 < seen_s < 0.5
