"""Sessions, touches and strokes on simulated devices, for Python programs."""

import tempfile
import weakref
from pathlib import Path

import numpy as np

from remote_site.traces.trace_files import StrokeTrace, ThermalTrace
from sim_sensors.traces import simulated_stroke, simulated_touch
from teletaction.api.recording import Recording
from teletaction.session.demo_files import DemoOptions
from teletaction.testbed.virtual_recording import record_session

OFFSET_K = 3.0
"""Largest difference of an object's temperature from ambient where none is given, K."""


def simulate(
    scene: str = "materials", seconds: float = 10.0, fingers: int = 5, seed: int = 0, out: Path | str | None = None
) -> Recording:
    """Run a session on simulated devices and a virtual clock, and return its recording.

    Args:
        scene: name of a shipped scene, or path of a scene file.
        seconds: duration of the exploration, s, above 0 and at most 3600.
        fingers: number of fingers, 1..5.
        seed: seed of the simulated world, 0 or more; the same seed gives the same session.
        out: folder for configurations and recordings; without one, they are deleted with the returned object.

    Raises:
        ValueError: an argument is out of range, or the scene has no calibrated table.
        OSError: a file cannot be written.
    """
    if not 0.0 < seconds <= 3600.0:
        raise ValueError(f"seconds must be above 0 and at most 3600, not {seconds}")
    if not isinstance(seed, int | np.integer) or seed < 0:
        raise ValueError(f"seed must be a whole number of 0 or more, not {seed}")
    options = DemoOptions(seconds=seconds, scene=scene, fingers=fingers, seed=int(seed))
    if out is not None:
        return Recording(record_session(options, Path(out)))
    folder = tempfile.TemporaryDirectory(prefix="teletaction-")
    recording = Recording(record_session(options, Path(folder.name)))
    weakref.finalize(recording, folder.cleanup)
    return recording


def simulate_thermal(
    material: str,
    seed: int = 0,
    *,
    seconds: float = 8.1,
    ambient_c: float = 23.0,
    preheat_k: float = 10.0,
    object_c: float | None = None,
    block: bool = False,
) -> ThermalTrace:
    """Return one touch of the simulated thermal sensor, at 100 Hz.

    Args:
        material: name of a material, such as `pvc`, or `air` for a free cool-down.
        seed: seed of the sensor, the piece and the touch, 0 or more.
        seconds: time in contact, 0.1..120 s.
        ambient_c: temperature of the air, 5..35 C.
        preheat_k: temperature of the sensor above ambient before contact, 0..19 K; at most 42 C in all.
        object_c: temperature of the object, -10..60 C; by default within 3 K of ambient.
        block: whether each touch is of one block of the material, not of a new piece.

    Raises:
        ValueError: the material is unknown, or a number is out of range.
    """
    offset_c = (-OFFSET_K, OFFSET_K) if object_c is None else (object_c - ambient_c,) * 2
    name = simulated_touch.known_material(material)
    (touch,) = simulated_touch.simulate_thermal(
        name, seed, seconds=seconds, ambient_c=ambient_c, preheat_k=preheat_k, offset_c=offset_c, block=block
    )
    return ThermalTrace(touch.time_s, touch.sensor_c, touch.force_n, touch.ambient_c, name=f"{name}, seed {seed}")


def simulate_stroke(surface: str, seed: int = 0, *, speed_m_s: float = 0.05, force_n: float = 1.2) -> StrokeTrace:
    """Return one stroke of the simulated texture sensor, at 2 kHz.

    Args:
        surface: name of a surface, such as `sandpaper` or `widely_grooved_pvc`.
        seed: seed of the surface and the stroke, 0 or more.
        speed_m_s: speed, 0.005..0.2 m/s.
        force_n: contact force, 0.5..5 N.

    Raises:
        ValueError: the surface is unknown, or a number is out of range.
    """
    stroke = simulated_stroke.simulate_stroke(surface, seed, 1000.0 * speed_m_s, force_n)
    return StrokeTrace(
        stroke.time_s,
        stroke.pressure_v,
        stroke.force_n,
        stroke.speed_mm_s / 1000.0,
        name=f"{surface}, seed {seed}",
    )
