"""A simulated texture sensor that is broken on command: named, and nothing of the surface is felt meanwhile."""

import numpy as np
import pytest

from common.wire.messages import ExplorationMode
from remote_site.devices.texture_sensor import VOLTS_PER_COUNT
from remote_site.texture.sensor_fault import CLIPPED, DISCONNECTED, NOISE_ONLY, SATURATED
from remote_site.texture.surface_table import SurfaceTable
from remote_site.texture.texture_identification import TextureIdentification, TextureReading
from sim_sensors.devices.breakable_parts import Piezo, PiezoFault
from sim_sensors.traces.simulated_stroke import simulate_stroke
from tests.places import TABLES

CHUNK = 10


def touched(identification: TextureIdentification, piezo: Piezo, seed: int) -> list[TextureReading]:
    """What is read, chunk by chunk, of one touch and stroke over a grating with this element."""
    stroke = simulate_stroke("widely_grooved_pvc", seed, 60.0, 2.0)
    readings = []
    for first in range(0, len(stroke.time_s) - CHUNK + 1, CHUNK):
        at = first + CHUNK - 1
        counts = np.rint(stroke.pressure_v[first : at + 1] / VOLTS_PER_COUNT).astype(np.int16)
        t_s, force_n = float(stroke.time_s[at]), float(stroke.force_n[at])
        mode = ExplorationMode.FREE if force_n < 0.15 else ExplorationMode.QUIESCENT
        if stroke.stroke_s[0] + 0.1 < t_s < stroke.stroke_s[1] - 0.1:
            mode = ExplorationMode.STROKING
        speed_m_s = 1e-3 * float(stroke.speed_mm_s[at])
        volts = piezo.read(counts) * VOLTS_PER_COUNT
        readings.append(identification.step(10.0 * seed + t_s, volts, force_n, speed_m_s, mode))
    return readings


@pytest.mark.long
@pytest.mark.parametrize(
    ("fault", "name"),
    [("saturated", SATURATED), ("clipped", CLIPPED), ("cut", DISCONNECTED), ("loose", NOISE_ONLY)],
)
def test_a_broken_element_is_named_and_ignored_until_it_is_sound_again(fault: PiezoFault, name: str) -> None:
    identification, piezo = TextureIdentification(SurfaceTable.load(TABLES / "surfaces.json")), Piezo()
    assert sum(len(reading.impulses) for reading in touched(identification, piezo, 0)) > 5
    piezo.fault = fault
    broken = touched(identification, piezo, 1)
    assert name in {reading.fault for reading in broken}
    assert not any(reading.impulses or reading.valid for reading in broken if reading.fault)
    named = next(n for n, reading in enumerate(broken) if reading.fault == name)
    assert sum(len(reading.impulses) for reading in broken[:named]) <= 2
    piezo.fault = None
    mended = touched(identification, piezo, 2)
    assert mended[-1].fault is None
    assert sum(len(reading.impulses) for reading in mended) > 5
