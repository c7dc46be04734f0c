"""Operator's finger in the exoskeleton, a link, and a remote finger on a wall: one degree of freedom, many runs.

Depth is positive into the wall; the wall's face is at 0 but for its breath. Both sites act every period and hold what
they told until the next; in between hand, device, servo and wall move in steps of 0.1 ms. The remote finger is that of
`sim_sensors.fingertip`, with a servo that gives no more than the contact force allowed on a patient.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from common.limits import CONTACT_FORCE_N
from sim_sensors.fingertip import MASS_KG, SERVO_N_M, SERVO_NS_M
from studies.stability_cases import DEVICE_KG, DEVICE_NS_M, WALL_NS_M, Cases, Floats
from studies.stability_network import Ints

STEP_S = 1e-4
ENCODER_M = 1e-5
"""Steps of both sites' measured places."""
FORCE_STEP_N, FORCE_NOISE_N = 10.0 / 4096.0, 0.01
"""Steps of 12 bits, and white noise, of the remote force."""
DEVICE_N = 12.0
"""The exoskeleton gives no more."""
BREATH_HZ = 0.3
"""A wall that breathes does so once: what still swings then swings by itself."""

Path = Callable[[float], tuple[Floats, Floats]]
"""Where the hand means to be at a time, s, and how fast: (N,), m and m/s."""


class Architecture(Protocol):
    """What both sites do at a tick. Packets are rows of (N,), all 0 before the first: places count from the start."""

    packet_rows: int

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """Force to show, N, against the finger, and the packet to send, for a finger at this depth."""

    def remote(
        self, depth_m: Floats, force_n: Floats, servo_n: Floats, packet: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Set-point, m, its speed, m/s, and the packet to send, for what is measured."""


@dataclass(frozen=True, slots=True)
class Course:
    """What happened, (ticks, N) each.

    Attributes:
        period_s: of the ticks.
        depth_m, remote_m: of the operator's and the remote finger.
        shown_n, contact_n: force shown to the operator and force at the wall.
        given_j: energy that came out of the exoskeleton towards the hand so far; negative: the hand put in more.
        wall_j: work that the moving wall has done on the remote finger so far.
    """

    period_s: float
    depth_m: Floats
    remote_m: Floats
    shown_n: Floats
    contact_n: Floats
    given_j: Floats
    wall_j: Floats


def simulate(
    runs: Cases,
    sites: Architecture,
    path: Path,
    forward: Ints,
    backward: Ints,
    *,
    period_s: float,
    rng: np.random.Generator,
) -> Course:
    """Let all runs pass at once.

    Args:
        runs: hands and walls.
        sites: what both sites do.
        path: what the hands mean to do.
        forward, backward: newest packet of each tick, (ticks, N); see `stability_network`.
        period_s: of the sites' ticks, a multiple of STEP_S.
        rng: of the noise of the remote force.
    """
    ticks, number = forward.shape
    steps = round(period_s / STEP_S)
    columns = np.arange(number)
    told, heard = np.zeros((2, ticks, sites.packet_rows, number))
    none = np.zeros((sites.packet_rows, number))
    kept = [np.empty((ticks, number)) for _ in range(6)]
    mass_kg = runs.hand_kg + DEVICE_KG
    x = path(0.0)[0].copy()
    y = x.copy()
    v, w, force, given, worked = np.zeros((5, number))
    servo, contact = np.zeros((2, number))
    for tick in range(ticks):
        t_s = tick * period_s
        measured_n = np.round((contact + FORCE_NOISE_N * rng.standard_normal(number)) / FORCE_STEP_N) * FORCE_STEP_N
        newest = np.minimum(backward[tick], tick - 1)  # the remote site answers after the operator's tick
        packet = np.where(newest >= 0, heard[newest, :, columns].T, none)
        force, told[tick] = sites.operator(_encoded(x), packet)
        force = np.clip(force, -DEVICE_N, DEVICE_N)
        newest = forward[tick]
        packet = np.where(newest >= 0, told[newest, :, columns].T, none)
        setpoint, pace, heard[tick] = sites.remote(_encoded(y), measured_n, servo, packet)
        for column, value in zip(kept, (x, y, force, contact, given - 0.5 * DEVICE_KG * v * v, worked), strict=True):
            column[tick] = value
        meant, meant_pace = path(t_s)
        pull = runs.hand_n_m * meant + runs.hand_ns_m * meant_pace - force
        drag = runs.hand_ns_m + DEVICE_NS_M
        for step in range(steps):
            breath = 2.0 * math.pi * min(1.0, BREATH_HZ * (t_s + step * STEP_S))
            face = -0.5 * (1.0 - math.cos(breath)) * runs.breath_m
            rise = math.pi * BREATH_HZ * math.sin(breath) * runs.breath_m
            v = (v + STEP_S / mass_kg * (pull - runs.hand_n_m * x)) / (1.0 + STEP_S * drag / mass_kg)
            x = x + STEP_S * v
            given -= STEP_S * v * (force + DEVICE_NS_M * v)
            setpoint = setpoint + STEP_S * pace
            servo = SERVO_N_M * (setpoint - y) + SERVO_NS_M * (pace - w)
            servo = np.minimum(CONTACT_FORCE_N, np.maximum(-CONTACT_FORCE_N, servo))
            inside = y - face
            contact = np.where(inside > 0.0, np.maximum(0.0, runs.wall_n_m * inside + WALL_NS_M * (w + rise)), 0.0)
            contact = contact * (runs.wall_n_m > 0.0)
            w = w + STEP_S / MASS_KG * (servo - contact)
            y = y + STEP_S * w
            worked += STEP_S * contact * rise
    return Course(period_s, *kept)


def _encoded(place_m: Floats) -> Floats:
    return np.asarray(np.round(place_m / ENCODER_M) * ENCODER_M)
