"""Single strokes of one finger over one surface through the physics of the simulated world."""

from dataclasses import dataclass
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.limits import CONTACT_FORCE_N
from common.scene import Scene, SceneObject
from common.surfaces import surface_kind
from sim_sensors.fingertip import pressing_depth_m
from sim_sensors.remote_world import HOVER_M, RemoteWorld
from sim_sensors.simulated_touch import FORCE_SPREAD, LOWER_S, TICK_S, check_range
from sim_sensors.texture_touch import OUTPUT_HZ, VOLTS_PER_COUNT

Array = NDArray[np.float64]

FINGER = FINGERS.index("index")
HOVER_S = 0.3
REST_S = 0.4
EDGE_M = 0.01
LENGTH_M = 0.08
"""Length of a stroke unless told otherwise, m."""


@dataclass(frozen=True, slots=True)
class StrokeTrace:
    """One stroke at 2 kHz: hover, lower, rest, stroke, rest, lift; and when grooves were truly crossed.

    `stroke_s` is when the hand's set-point starts and stops to travel.
    """

    time_s: Array
    pressure_v: Array
    force_n: Array
    speed_mm_s: Array
    groove_s: tuple[float, ...]
    stroke_s: tuple[float, float]


def simulate_stroke(
    surface: str, seed: int, speed_mm_s: float = 50.0, force_n: float = 1.2, *, length_m: float = LENGTH_M
) -> StrokeTrace:
    """Stroke once over `length_m` of a surface that is drawn for this stroke.

    Args:
        surface: a kind of surface.
        seed: all randomness.
        speed_mm_s: stroke speed, mm/s.
        force_n: nominal resting force, N; the stroke draws 0.9..1.1 of it.
        length_m: length of the stroke, m.

    Raises:
        ValueError: unknown surface, or a number out of range.
    """
    kind = surface_kind(surface)
    check_range("speed, mm/s", speed_mm_s, 5.0, 200.0)
    check_range("force, N", force_n, 0.5, CONTACT_FORCE_N)
    check_range("stroke length, m", length_m, 0.005, 0.5)
    check_range("seed", seed, 0, 2**53)
    world = RemoteWorld(_one_object(surface, length_m), _world_seed(surface, seed), (FINGERS[FINGER],))
    draw = np.random.default_rng([seed, crc32(surface.encode())])
    depth = pressing_depth_m(force_n * draw.uniform(*FORCE_SPREAD), kind.stiffness_n_m)
    start_x = draw.uniform(0.0, 0.5 * EDGE_M)
    begin = HOVER_S + LOWER_S + REST_S
    end = begin + length_m / (1e-3 * speed_mm_s)
    lift = end + REST_S
    knots = np.array([0.0, HOVER_S, HOVER_S + LOWER_S, lift, lift + LOWER_S])
    heights = np.array([HOVER_M, HOVER_M, -depth, -depth, HOVER_M])
    ticks = round((lift + LOWER_S) / TICK_S)
    now = TICK_S * np.arange(ticks)
    z = np.interp(now, knots, heights)
    x = start_x + np.clip((now - begin) / (end - begin), 0.0, 1.0) * length_m
    idle = np.zeros(len(FINGERS))
    force, speed = np.empty(ticks), np.empty(ticks)
    counts = []
    for tick in range(ticks):
        world.step(TICK_S, float(x[tick]), 0.0, np.full(len(FINGERS), z[tick]), idle)
        force[tick], speed[tick] = world.measured_force_n[FINGER], 1e3 * world.speed_m_s
        counts.append(world.take_texture_counts()[FINGER])
    pressure = np.concatenate(counts) * VOLTS_PER_COUNT
    time_s = (1 + np.arange(pressure.size)) / OUTPUT_HZ
    return StrokeTrace(
        time_s,
        pressure,
        np.interp(time_s, now + TICK_S, force),
        np.interp(time_s, now + TICK_S, speed),
        tuple(event.time_s for event in world.take_events() if event.kind == "groove"),
        (begin, end),
    )


def _world_seed(surface: str, seed: int) -> int:
    """One whole number from seed and surface: two surfaces never share their draws."""
    return seed << 32 | crc32(surface.encode())


def _one_object(surface: str, length_m: float) -> Scene:
    block = SceneObject(name="block", material="pvc", surface=surface, x_m=0.0, length_m=length_m + EDGE_M)
    return Scene(name="stroke", objects=(block,))
