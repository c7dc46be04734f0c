"""Simulates many runs of an operator's finger in the exoskeleton, a link, and a remote finger on a wall.

The model has one degree of freedom. Depth is positive into the wall, and the wall's face is at 0 except for its breath.
Both sites act every period and hold their outputs until the next. In between, hand, device, servo and wall move in
steps of 0.1 ms. The remote finger is that of `sim_sensors.physics.fingertip`; its servo gives at most the contact
force allowed on a patient.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from common.limits import CONTACT_FORCE_N
from sim_sensors.physics.fingertip import MASS_KG, SERVO_N_M, SERVO_NS_M
from studies.teleoperation_stability.cases import DEVICE_KG, DEVICE_NS_M, WALL_NS_M, Cases, Floats, Measured
from studies.teleoperation_stability.network import Ints

STEP_S = 1e-4
ENCODER_M = 1e-5
"""Resolution of both sites' position measurement, m."""
FORCE_STEP_N, FORCE_NOISE_N = 10.0 / 4096.0, 0.01
"""Resolution (12 bits) and standard deviation of the white noise of the measured remote force, N."""
DEVICE_N = 12.0
"""Largest force of the exoskeleton, N."""
BREATH_HZ = 0.3
"""Frequency of a breathing wall, Hz; it breathes once, so that a later oscillation is the system's own."""

Path = Callable[[float], tuple[Floats, Floats]]
"""Intended position, m, and speed, m/s, of the hand at a time, s; (N,) each."""


class Architecture(Protocol):
    """Control of both sites at a tick.

    Packets are rows of (N,), all 0 before the first packet arrives, so positions are relative to the start.
    """

    packet_rows: int

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """Return the force to show against the finger, N, and the packet to send, for a finger at this depth."""

    def remote(self, at: Measured, packet: Floats) -> tuple[Floats, Floats, Floats]:
        """Return set-point, m, its speed, m/s, and the packet to send, for these measurements."""


@dataclass(frozen=True, slots=True)
class Course:
    """Course of the runs, (ticks, N) each.

    Attributes:
        period_s: period of the ticks.
        depth_m, remote_m: depth of the operator's and of the remote finger.
        shown_n, contact_n: force shown to the operator and force at the wall.
        given_j: net energy given by the exoskeleton to the hand so far; negative if the hand put in more.
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
    """Simulate all runs at once.

    Args:
        runs: hands and walls.
        sites: control of both sites.
        path: intended path of the hands.
        forward, backward: newest packet of each tick, (ticks, N); see `network`.
        period_s: period of the sites' ticks, a multiple of STEP_S.
        rng: random generator of the noise of the remote force.
    """
    ticks, number = forward.shape
    steps = round(period_s / STEP_S)
    columns = np.arange(number)
    sent, returned = np.zeros((2, ticks, sites.packet_rows, number))
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
        packet = np.where(newest >= 0, returned[newest, :, columns].T, none)
        force, sent[tick] = sites.operator(_encoded(x), packet)
        force = np.clip(force, -DEVICE_N, DEVICE_N)
        newest = forward[tick]
        packet = np.where(newest >= 0, sent[newest, :, columns].T, none)
        setpoint, pace, returned[tick] = sites.remote(Measured(_encoded(y), measured_n, servo), packet)
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
