"""Simulate the piezo texture sensors of n remote fingers: from motion over a height profile to 12-bit counts at 2 kHz.

    p_raw = F_n + F_n c g (z + tau dz/dt),    z = path of the ball-shaped tip, c = relief stiffness per unit force

A leaky integrator (no DC), a low-pass, noise and the converter follow. Motion is stored as knots and interpolated to
8 kHz when counts are taken, so the result is independent of the interval between calls.
Constants: docs/decisions/0002-simulated-world.md.
"""

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from sim_sensors.physics.surface import GRID_M

Array = NDArray[np.float64]
_Span = tuple[list[float], list[int], list[float]]

OUTPUT_HZ = 2000.0
OVERSAMPLING = 4
BLOCK = 10
"""Samples in a block; samples leave the sensor in whole blocks of 5 ms."""
INNER_HZ = OUTPUT_HZ * OVERSAMPLING
_INNER_BLOCK = BLOCK * OVERSAMPLING
HIGH_PASS_HZ = 3.0
LOW_PASS_HZ = 800.0
RELIEF_PER_M = 12_000.0
TIP_MOUNT_N_M = 1000.0
VISCOUS_S = 0.001
NOISE_V = 0.008
VOLTS_PER_COUNT = 10.0 / 2048.0
"""Resolution of the converter, V: +-2048 counts are +-10 V; 1 V represents 1 N."""


def compliance_share(stiffness_n_m: float) -> float:
    """Return the share of a height fluctuation that reaches the tip, 0..1; a softer object yields more."""
    return stiffness_n_m / (stiffness_n_m + TIP_MOUNT_N_M)


class TextureTouch:
    """Texture sensors of n fingers over a bank of tracks.

    `heights_m` and `slopes` are the bank: all tracks end to end. A knot holds, for each finger, the start of its track
    in the bank and the x of that start.
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
        self._count = count
        self._filter = _block_filter()
        self._state = np.zeros((self._filter.shape[1] - _INNER_BLOCK, count))
        self._taken = 0
        self._knots: list[list[float]] = [[0.0] * (2 + count)]
        """Knots: time, s, x, m, and the force of each finger, N."""
        self._spans: list[_Span] = []
        """Gain, track and origin of each finger from each knot to the next."""
        self._nothing = np.empty((count, 0), dtype=np.int16)

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
            gain: c g of the object below each finger, 1/m (0: no object).
            track: index in the bank at which each finger's track starts; the track must cover the x range.
            origin_m: x of that start, m.
        """
        self._knots.append([time_s, x_m, *force_n])
        self._spans.append((gain, track, origin_m))

    def take_counts(self) -> NDArray[np.int16]:
        """Return the counts of all blocks completed since the last call, (n, samples) at 2 kHz."""
        blocks = math.floor(self._knots[-1][0] * (OUTPUT_HZ / BLOCK) + 1e-6)
        last = blocks * _INNER_BLOCK
        if last <= self._taken or not self._spans:
            return self._nothing
        at = np.arange(self._taken + 1, last + 1) / INNER_HZ
        self._taken = last
        volts = self._filtered(self._raw(at)).T
        volts += self._noise_v * self._rng.standard_normal(volts.shape)
        self._forget(float(at[-1]))
        counts = np.rint(volts * (1.0 / VOLTS_PER_COUNT))
        clipped: NDArray[np.int16] = np.minimum(np.maximum(counts, -2048), 2047).astype(np.int16)
        return clipped

    def _raw(self, at: Array) -> Array:
        """Return the piezo's raw signal at ascending times, s, (samples, n)."""
        if not any(any(knot[2:]) for knot in self._knots):
            return np.zeros((len(at), self._count))
        knots = np.array(self._knots)
        segment = np.minimum(knots[1:, 0].searchsorted(at - 1e-9), len(self._spans) - 1)
        before, change = knots.take(segment, axis=0), (knots[1:] - knots[:-1]).take(segment, axis=0)
        span = change[:, 0]
        now = before + ((at - before[:, 0]) / span)[:, None] * change
        force: Array = now[:, 2:]
        force *= 1.0 + self._relief(segment, now[:, 1:2], (change[:, 1] / span)[:, None])
        return force

    def _relief(self, segment: NDArray[np.intp], x: Array, speed: Array) -> Array:
        """Return the relative force fluctuation (samples, n) from the relief and its rate of change at x and speed."""
        first = self._spans[0]
        if all(span == first for span in self._spans):
            gain, track, origin = (np.array(part) for part in first)
        else:
            gain, track, origin = (np.array(part).take(segment, axis=0) for part in zip(*self._spans, strict=True))
        cell = np.maximum((x - origin) * (1.0 / GRID_M), 0.0)
        whole = cell.astype(np.intp)
        share = cell - whole
        index = np.minimum(track + whole, self._heights.size - 2)
        height = self._heights.take(index)
        height = height + share * (self._heights.take(index + 1) - height)
        relief: Array = gain * (height + (VISCOUS_S * speed) * self._slopes.take(index))
        return relief

    def _filtered(self, raw: Array) -> Array:
        """Return the amplifier's output for whole blocks, at the output rate, (samples, n)."""
        volts = []
        for start in range(0, len(raw), _INNER_BLOCK):
            after = self._filter @ np.concatenate((raw[start : start + _INNER_BLOCK], self._state))
            volts.append(after[:BLOCK])
            self._state = after[BLOCK:]
        return volts[0] if len(volts) == 1 else np.concatenate(volts)

    def _forget(self, until_s: float) -> None:
        """Drop knots that no later sample needs."""
        keep = 0
        while keep + 2 < len(self._knots) and self._knots[keep + 1][0] <= until_s + 1e-9:
            keep += 1
        del self._knots[:keep]
        del self._spans[:keep]


@cache
def _block_filter() -> Array:
    """Return the amplifier's filters over one block as a matrix from inner samples and state to outputs and state."""
    sections = np.vstack(
        (
            butter(1, HIGH_PASS_HZ, "highpass", fs=INNER_HZ, output="sos"),
            butter(2, LOW_PASS_HZ, "lowpass", fs=INNER_HZ, output="sos"),
        )
    )
    states = 2 * len(sections)
    each = np.eye(_INNER_BLOCK + states)
    samples, before = each[:, :_INNER_BLOCK], each[:, _INNER_BLOCK:].reshape(-1, len(sections), 2)
    volts, after = sosfilt(sections, samples, zi=before.swapaxes(0, 1))
    matrix: Array = np.vstack(
        (volts[:, OVERSAMPLING - 1 :: OVERSAMPLING].T, after.swapaxes(0, 1).reshape(-1, states).T)
    )
    return matrix
