"""Estimates compliance below a finger in contact with a surface that moves by itself, as a breathing patient's does.

    z = r + b - c F / (1 + a v)

The surface is at a rest height r, displaced by b, a damped oscillator driven by white noise. Its standard deviation and
its frequency are those of breathing, so the prior knows how far and how fast a surface can come up during a press. A
slow press on a hard object then teaches little about the compliance c, and several fast ones teach it. A Kalman filter
has the states r, b, its speed, and c.

Only samples whose force has changed teach c. During a rest, the noise of the force would be taken for yielding.
"""

import math

import numpy as np
from numpy.typing import NDArray

MOTION_M, MOTION_HZ, MOTION_DAMPING = 1.5e-3, 0.33, 0.2
"""Standard deviation, m, natural frequency, Hz, and damping ratio of the displacement.

A skin that breathes by 2 mm to each side has 1.4 mm, and an adult at rest takes 12 to 20 breaths a minute.
"""
DRIFT_M_S05 = 0.1e-3
"""Drift of the rest height, m per root of a second."""
CHANGE_S05 = 0.03
"""Change of ln c per root of a second of pressing: a finger that presses moves on slowly, and tissue relaxes."""

_PULSE = 2.0 * math.pi * MOTION_HZ
_SETTLED = MOTION_M**2 * np.diag([1.0, _PULSE**2])

Array = NDArray[np.float64]


class MovingSurface:
    """Filter of one contact, from the time at which its surface was found to move."""

    def __init__(self, t_s: float, force_n: float, surface_m: float, compliance_m_n: float, variance: float) -> None:
        """Begin at a time, s, with a force, N, a surface height, m, and a compliance, m/N, with its variance, m2/N2."""
        self._t_s = t_s
        self._state = np.array([surface_m, 0.0, 0.0, compliance_m_n])
        self._cov = np.zeros((4, 4))
        self._cov[1:3, 1:3] = _SETTLED
        # Place and force are measured: rest height, displacement and compliance share their errors.
        self._cov[0] = [MOTION_M**2 + force_n**2 * variance, -(MOTION_M**2), 0.0, force_n * variance]
        self._cov[1:, 0] = self._cov[0, 1:]
        self._cov[3, 3] = variance

    @property
    def surface_m(self) -> float:
        """Present height of the undeformed surface, m."""
        return float(self._state[0] + self._state[1])

    @property
    def compliance_m_n(self) -> float:
        """Compliance c, m/N; it can be out of the range of stiffnesses."""
        return float(self._state[3])

    @property
    def variance_m2_n2(self) -> float:
        """Variance of c, m2/N2."""
        return float(self._cov[3, 3])

    def step(self, t_s: float, z_m: float, by_c: float, noise_m2: float, way_m2: float, teaches: bool) -> float:
        """Take a sample; return its innovation in standard deviations.

        Args:
            t_s: time, s.
            z_m: height of the fingertip, m.
            by_c: derivative of this height by c, -F / (1 + a v), N.
            noise_m2: variance of the height, m2.
            way_m2: variance of the change of height along a stroke since the last call, m2.
            teaches: whether the force has changed, so that the sample teaches c.
        """
        seconds = t_s - self._t_s
        self._t_s = t_s
        state, cov = self._state, self._cov
        moves = _transition(seconds)
        state[1:3] = moves @ state[1:3]
        cov[1:3] = moves @ cov[1:3]
        cov[:, 1:3] = cov[:, 1:3] @ moves.T
        cov[1:3, 1:3] += _SETTLED - moves @ _SETTLED @ moves.T
        cov[0, 0] += DRIFT_M_S05**2 * seconds + way_m2
        if teaches:
            cov[3, 3] += (CHANGE_S05 * state[3]) ** 2 * seconds
        measures = np.array([1.0, 1.0, 0.0, by_c])
        cross = cov @ measures
        variance = float(measures @ cross) + noise_m2
        innovation_m = z_m - float(measures @ state)
        gain = cross / variance
        if not teaches:
            gain[3] = 0.0
        state += gain * innovation_m
        shared = np.outer(gain, cross)
        cov += variance * np.outer(gain, gain) - shared - shared.T
        return innovation_m / math.sqrt(variance)


def motion_sd_m(seconds: float) -> float:
    """Return the standard deviation of the surface's motion within a time, m."""
    return MOTION_M * math.sqrt(2.0 * (1.0 - float(_transition(seconds)[0, 0])))


def _transition(seconds: float) -> Array:
    """Return the transition of displacement and its speed over a time, s."""
    decay, damped = MOTION_DAMPING * _PULSE, _PULSE * math.sqrt(1.0 - MOTION_DAMPING**2)
    cos, sin = math.cos(damped * seconds), math.sin(damped * seconds) / damped
    return math.exp(-decay * seconds) * np.array(
        [[cos + decay * sin, sin], [-(_PULSE**2) * sin, cos - decay * sin]], dtype=np.float64
    )
