"""Simulate single strokes of one finger over a surface with the physics of the simulated world."""

from dataclasses import dataclass
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.limits import CONTACT_FORCE_N
from common.scenes.scene import Scene, SceneObject
from common.scenes.surfaces import surface_kind
from sim_sensors.physics.fingertip import pressing_depth_m
from sim_sensors.physics.remote_world import HOVER_M, RemoteWorld
from sim_sensors.physics.surface import GROOVE_DEPTH_M
from sim_sensors.physics.texture_touch import NOISE_V, OUTPUT_HZ, VOLTS_PER_COUNT
from sim_sensors.traces.simulated_touch import FORCE_SPREAD, LOWER_S, TICK_S, check_range

Array = NDArray[np.float64]

FINGER = FINGERS.index("index")
HOVER_S = 0.3
REST_S = 0.4
EDGE_M = 0.01
LENGTH_M = 0.08
"""Default length of a stroke, m."""


@dataclass(frozen=True, slots=True)
class StrokeTrace:
    """One stroke at 2 kHz: hover, lower, rest, stroke, rest, lift; `groove_s` holds the true times of groove crossings.

    `stroke_s` holds the times at which the hand's set-point starts and stops. `border_s` is the time at which the tip
    reaches the second surface, None without one.
    """

    time_s: Array
    pressure_v: Array
    force_n: Array
    speed_mm_s: Array
    groove_s: tuple[float, ...]
    stroke_s: tuple[float, float]
    border_s: float | None = None


def simulate_stroke(
    surface: str,
    seed: int,
    speed_mm_s: float = 50.0,
    force_n: float = 1.2,
    *,
    length_m: float = LENGTH_M,
    then: str | None = None,
    groove_depth_m: float = GROOVE_DEPTH_M,
    noise_v: float = NOISE_V,
) -> StrokeTrace:
    """Stroke once over `length_m` of a surface that is drawn for this stroke.

    Args:
        surface: a kind of surface.
        seed: source of all randomness.
        speed_mm_s: stroke speed, mm/s.
        force_n: nominal resting force, N; the stroke draws 0.9..1.1 of it.
        length_m: length of the stroke, m.
        then: another kind of surface for the second half of the stroke; the hand keeps the force.
        groove_depth_m: depth of grooves, m.
        noise_v: noise of the sensor, rms, V.

    Raises:
        ValueError: unknown surface, or a number out of range.
    """
    check_range("speed, mm/s", speed_mm_s, 5.0, 200.0)
    check_range("force, N", force_n, 0.5, CONTACT_FORCE_N)
    check_range("stroke length, m", length_m, 0.005, 0.5)
    check_range("groove depth, m", groove_depth_m, 0.0, 1e-3)
    check_range("sensor noise, V", noise_v, 0.0, 1.0)
    check_range("seed", seed, 0, 2**53)
    surfaces = (surface,) if then is None else (surface, then)
    kinds = [surface_kind(name) for name in surfaces]
    scene = _scene(surfaces, length_m)
    names = (FINGERS[FINGER],)
    world = RemoteWorld(
        scene, _world_seed(surface, seed), names, texture_noise_v=noise_v, groove_depth_m=groove_depth_m
    )
    draw = np.random.default_rng([seed, crc32(surface.encode())])
    wanted_n = force_n * draw.uniform(*FORCE_SPREAD)
    depths = [pressing_depth_m(wanted_n, kind.stiffness_n_m) for kind in kinds]
    start_x = draw.uniform(0.0, 0.5 * EDGE_M)
    begin = HOVER_S + LOWER_S + REST_S
    end = begin + length_m / (1e-3 * speed_mm_s)
    lift = end + REST_S
    knots = np.array([0.0, HOVER_S, HOVER_S + LOWER_S, lift, lift + LOWER_S])
    down = np.array([0.0, 0.0, 1.0, 1.0, 0.0])
    ticks = round((lift + LOWER_S) / TICK_S)
    now = TICK_S * np.arange(ticks)
    x = start_x + np.clip((now - begin) / (end - begin), 0.0, 1.0) * length_m
    border_m = scene.objects[0].end_x_m
    lowered = np.interp(now, knots, down)
    idle = np.zeros(len(FINGERS))
    force, speed = np.empty(ticks), np.empty(ticks)
    counts = []
    border_s = None
    for tick in range(ticks):
        depth = depths[0] if border_s is None else depths[-1]
        z = HOVER_M - lowered[tick] * (HOVER_M + depth)
        world.step(TICK_S, float(x[tick]), 0.0, np.full(len(FINGERS), z), idle)
        force[tick], speed[tick] = world.measured_force_n[FINGER], 1e3 * world.speed_m_s
        counts.append(world.take_texture_counts()[FINGER])
        if then is not None and border_s is None and world.x_m >= border_m:
            border_s = world.time_s
    pressure = np.concatenate(counts) * VOLTS_PER_COUNT
    time_s = (1 + np.arange(pressure.size)) / OUTPUT_HZ
    return StrokeTrace(
        time_s,
        pressure,
        np.interp(time_s, now + TICK_S, force),
        np.interp(time_s, now + TICK_S, speed),
        tuple(event.time_s for event in world.take_events() if event.kind == "groove"),
        (begin, end),
        border_s,
    )


def _world_seed(surface: str, seed: int) -> int:
    """Combine seed and surface to one integer, so that two surfaces never share their random draws."""
    return seed << 32 | crc32(surface.encode())


def _scene(surfaces: tuple[str, ...], length_m: float) -> Scene:
    """Lay the surfaces in a row, each with an equal share of the stroke; the last one extends beyond the stroke."""
    share_m = length_m / len(surfaces)
    blocks = tuple(
        SceneObject(
            name=f"block_{number}" if number else "block",
            material="pvc",
            surface=surface,
            x_m=0.0 if not number else 0.5 * EDGE_M + share_m * number,
            length_m=share_m + (0.5 * EDGE_M if len(surfaces) > 1 else EDGE_M),
        )
        for number, surface in enumerate(surfaces)
    )
    return Scene(name="stroke", objects=blocks)
