"""Simulates a fingertip that strokes a virtual surface, rendered from its constants on the simulated motor."""

from bisect import bisect_right
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from common.config.site_models import RenderingConfig, VibrationScale
from common.exploration.contact_detector import TAP_S
from common.scenes.surfaces import surface_kind
from common.wire.messages import Event, EventKind, ExplorationMode
from operator_site.vibration.motor_drive import motor_mv
from remote_site.texture.surface_table import GROOVE_DECAY_PER_S, GROOVE_RAD_S, TAP_DECAY_PER_S, TAP_SPEED_PER_M_S
from sim_sensors.physics.motor import RPM_PER_RAD_S, VibrationMotors
from studies.touches.lowering import LOWER_S, height_m
from studies.touches.simulated_finger import Array
from studies.touches.stroke_path import FORCE_N, HOVER_S, REST_S, SECONDS, SPEED_M_S, place_m
from studies.touches.virtual_touch import touch_packet
from teletaction.testbed.remote_fingers import INDEX
from teletaction.testbed.rendered_fingers import TICK_S, RenderedFingers

SHOWN_N_M = 400.0
"""Largest displayed stiffness in the default configuration, N/m."""
DEPTH_M = FORCE_N / SHOWN_N_M


@dataclass(frozen=True, slots=True)
class VirtualSurface:
    """Constants of Eq. 2, places of the grooves, m, and stiffness, N/m."""

    k_stroke_v: float
    k_stroke_f: float
    grooves_m: tuple[float, ...] = ()
    stiffness_n_m: float = SHOWN_N_M

    @classmethod
    def of(cls, name: str, grooves_m: tuple[float, ...] = ()) -> "VirtualSurface":
        """Return a surface with the constants that the remote site has; raise ValueError if it is unknown."""
        kind = surface_kind(name)
        return cls(kind.k_stroke_v, kind.k_stroke_f, grooves_m)


class FingertipCourse(NamedTuple):
    """One value per tick: mode, motor speed wanted by the gate and reached, rad/s, force, N, and depth, m."""

    time_s: Array
    mode: Array
    wanted_rad_s: Array
    speed_rad_s: Array
    force_n: Array
    depth_m: Array

    @classmethod
    def of(cls, ticks: list[tuple[float, ...]]) -> "FingertipCourse":
        """Build a course from the values of each tick."""
        return cls(*np.array(ticks).T)


def tick_of(hand: RenderedFingers, mode: int, depth_m: float) -> tuple[float, ...]:
    """Return the index finger's values in the hand's last tick."""
    output = hand.output
    assert output is not None, "a hand has an output after its first tick"
    wanted = output.motor_rpm[INDEX] / RPM_PER_RAD_S
    return hand.time_s, mode, wanted, float(hand.motors.speed_rad_s[INDEX]), output.force_n[INDEX], depth_m


def left_to_itself(course: FingertipCourse) -> FingertipCourse:
    """Return the course with a motor that only gets the steady-state voltage of each wanted speed."""
    motor, speeds = VibrationMotors(1), []
    for wanted_rad_s in course.wanted_rad_s:
        motor.step(TICK_S, np.array([1e-3 * motor_mv(float(wanted_rad_s) * RPM_PER_RAD_S)]))
        speeds.append(float(motor.speed_rad_s[0]))
    return course._replace(speed_rad_s=np.array(speeds))


def rendered_stroke(
    surface: VirtualSurface,
    seed: int = 0,
    *,
    lower_s: float = LOWER_S,
    stroke_m_s: float = SPEED_M_S,
    vibration: VibrationScale = "speed",
) -> FingertipCourse:
    """Tap a surface, rest on it and stroke along it; each crossed groove sends an event."""
    hand, known = RenderedFingers(seed, RenderingConfig(vibration=vibration)), _columns(surface)
    events: list[Event] = []
    ticks, contact_s, before_z_m = [], None, height_m(0.0, DEPTH_M)
    crossed = bisect_right(surface.grooves_m, place_m(0.0))
    for tick in range(round(SECONDS / TICK_S)):
        time_s = tick * TICK_S
        x_m, z_m = place_m(time_s, stroke_m_s), height_m(time_s - HOVER_S, DEPTH_M, lower_s)
        time_ns = round(time_s * 1e9)
        if contact_s is None and z_m < 0.0:
            contact_s = time_s
            events.append(Event(1, EventKind.TAP, INDEX, time_ns, 0, (before_z_m - z_m) / TICK_S))
        before_z_m = z_m
        for _ in range(crossed, now_crossed := bisect_right(surface.grooves_m, x_m)):
            events.append(Event(len(events) + 1, EventKind.GROOVE, INDEX, time_ns, 0, GROOVE_RAD_S))
        crossed = now_crossed
        mode = ExplorationMode.FREE if contact_s is None else _mode(time_s, contact_s)
        columns = {} if contact_s is None else {INDEX: known | {"mode": mode}}
        hand.step(touch_packet(tick + 1, columns, events[-4:]), x_m, z_m)
        ticks.append(tick_of(hand, mode, -z_m))
    return FingertipCourse.of(ticks)


def _mode(time_s: float, contact_s: float) -> ExplorationMode:
    if time_s < contact_s + TAP_S:
        return ExplorationMode.TAPPING
    return ExplorationMode.STROKING if time_s > REST_S else ExplorationMode.QUIESCENT


def _columns(surface: VirtualSurface) -> dict[str, float]:
    return {
        "contact": 1.0,
        "contact_force_n": FORCE_N,
        "stiffness_n_m": surface.stiffness_n_m,
        "k_tap": TAP_SPEED_PER_M_S,
        "b_tap_per_s": TAP_DECAY_PER_S,
        "k_stroke_v": surface.k_stroke_v,
        "k_stroke_f": surface.k_stroke_f,
        "groove_rad_s": GROOVE_RAD_S,
        "b_groove_per_s": GROOVE_DECAY_PER_S,
    }
