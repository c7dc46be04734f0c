"""The piezo texture sensors of n remote fingers: motion over a height profile in, 12-bit counts at 2 kHz out.

    p_raw = F_n + F_n c g (z + tau dz/dt),    z = path of the ball-shaped tip, c = relief stiffness per unit force

then a leaky integrator (there is no DC), a low-pass, noise and the converter. Motion is kept as knots and worked off
when counts are taken, interpolated to 8 kHz, so it does not matter how often that happens.
Constants: docs/decisions/0002-simulated-world.md.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from sim_sensors.surface import GRID_M

Array = NDArray[np.float64]

OUTPUT_HZ = 2000.0
OVERSAMPLING = 4
BLOCK = 10
"""Samples leave the sensor in whole blocks of 5 ms."""
INNER_HZ = OUTPUT_HZ * OVERSAMPLING
HIGH_PASS_HZ = 3.0
LOW_PASS_HZ = 800.0
RELIEF_PER_M = 12_000.0
TIP_MOUNT_N_M = 1000.0
VISCOUS_S = 0.001
NOISE_V = 0.008
VOLTS_PER_COUNT = 10.0 / 2048.0
"""Converter: +-2048 counts are +-10 V, and 1 V stands for 1 N."""


def compliance_share(stiffness_n_m: float) -> float:
    """Share of a height fluctuation that reaches the tip on an object of this stiffness: soft ones give way."""
    return stiffness_n_m / (stiffness_n_m + TIP_MOUNT_N_M)


class TextureTouch:
    """Texture sensors of n fingers over a bank of tracks.

    `heights_m` and `slopes` are all tracks end to end; a knot names for each finger where its track starts in
    the bank and at which x that start lies.
    """

    def __init__(
        self,
        count: int,
        heights_m: NDArray[np.float32],
        slopes: NDArray[np.float32],
        rng: np.random.Generator,
        noise_v: float = NOISE_V,
    ) -> None:
        self._rng = rng
        self._noise_v = noise_v
        self._heights = heights_m
        self._slopes = slopes
        self._sections = np.vstack(
            (
                butter(1, HIGH_PASS_HZ, "highpass", fs=INNER_HZ, output="sos"),
                butter(2, LOW_PASS_HZ, "lowpass", fs=INNER_HZ, output="sos"),
            )
        )
        self._state = np.zeros((self._sections.shape[0], count, 2))
        self._taken = 0
        self._time: list[float] = [0.0]
        self._x: list[float] = [0.0]
        self._force: list[list[float]] = [[0.0] * count]
        self._gain: list[list[float]] = []
        self._track: list[list[int]] = []
        self._origin: list[list[float]] = []

    def step(
        self,
        time_s: float,
        x_m: float,
        *,
        force_n: list[float],
        gain: list[float],
        track: list[int],
        origin_m: list[float],
    ) -> None:
        """Add a knot: the state at `time_s`, reached from the last knot in a straight line.

        Args:
            time_s: simulated time, ascending, s.
            x_m: position of the tips along the stroke, m.
            force_n: contact force of each finger, N.
            gain: c g of what each finger touches, 1/m (0: nothing below).
            track: index in the bank where each finger's track starts; it must hold what the x range needs.
            origin_m: x of that start, m.
        """
        self._time.append(time_s)
        self._x.append(x_m)
        self._force.append(force_n)
        self._gain.append(gain)
        self._track.append(track)
        self._origin.append(origin_m)

    def take_counts(self) -> NDArray[np.int16]:
        """Counts of all whole blocks since the last call, (n, samples) at 2 kHz; a begun block waits for its end."""
        blocks = math.floor(self._time[-1] * (OUTPUT_HZ / BLOCK) + 1e-6)
        last = blocks * BLOCK * OVERSAMPLING
        count = len(self._force[0])
        if last <= self._taken or not self._gain:
            return np.empty((count, 0), dtype=np.int16)
        at = np.arange(self._taken + 1, last + 1) / INNER_HZ
        self._taken = last
        knots = np.asarray(self._time)
        segment = np.minimum(np.searchsorted(knots[1:], at - 1e-9), len(self._gain) - 1)
        span = knots[segment + 1] - knots[segment]
        part = (at - knots[segment]) / span
        path = np.asarray(self._x)
        travel = path[segment + 1] - path[segment]
        x = path[segment] + part * travel
        force_knots = np.asarray(self._force)
        before = force_knots[segment].T
        force = before + part * (force_knots[segment + 1].T - before)
        raw = force * (1.0 + self._relief(segment, x, travel / span))
        volts, self._state = sosfilt(self._sections, raw, axis=1, zi=self._state)
        volts = volts[:, OVERSAMPLING - 1 :: OVERSAMPLING]
        volts += self._noise_v * self._rng.standard_normal(volts.shape)
        self._forget(at[-1])
        counts = np.rint(volts * (1.0 / VOLTS_PER_COUNT))
        clipped: NDArray[np.int16] = np.minimum(np.maximum(counts, -2048), 2047).astype(np.int16)
        return clipped

    def _relief(self, segment: NDArray[np.intp], x: Array, speed: Array) -> Array:
        """Relative force fluctuation (n, samples) from relief and its rate of change."""
        gain = np.asarray(self._gain)[segment].T
        if not gain.any():
            return np.zeros(gain.shape)
        origin = np.asarray(self._origin)[segment].T
        track = np.asarray(self._track)[segment].T
        cell = np.maximum((x - origin) * (1.0 / GRID_M), 0.0)
        whole = cell.astype(np.intp)
        share = cell - whole
        index = np.minimum(track + whole, self._heights.size - 2)
        height = self._heights[index]
        height = height + share * (self._heights[index + 1] - height)
        relief: Array = gain * (height + (VISCOUS_S * speed) * self._slopes[index])
        return relief

    def _forget(self, until_s: float) -> None:
        """Drop knots that lie wholly before the next sample."""
        keep = 0
        while keep + 2 < len(self._time) and self._time[keep + 1] <= until_s + 1e-9:
            keep += 1
        for knots in (self._time, self._x, self._force):
            del knots[:keep]
        for spans in (self._gain, self._track, self._origin):
            del spans[:keep]
