"""Roughness and groove impulses from the texture signal (Kron & Schmidt 2003, Eq. 5-6 with the pattern hold).

The mean of the rectified signal describes the surface; a groove must not enter it. The paper holds
the mean while the signal is much greater than it. As printed that fails in four ways, each met here:
a single noisy sample raises a flag (so a 5 ms envelope is compared), the plain average of Eq. 6
forgets nothing (so it forgets with TAU_S), a change to a rougher surface never ends its "pattern" (so a
pattern is limited in time and travel, after which the mean starts again), and the sensor's leaky
integrator answers each groove with a tail of 50 ms (so its leak is undone first).
"""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.messages import ExplorationMode

RATE_HZ = 2000.0
LEAK_HZ = 3.0
"""Corner of the texture sensor's leaky integrator, Hz."""
DRIFT_HZ = 0.02
"""Undoing the leak would sum noise for ever; below this it is let go, Hz."""
CLIP_V = 9.98
TAU_S = 0.30
SEED_CHUNKS = 10
"""Chunks (50 ms) of stroking before the mean is one and before any flag."""
BASELINE_CHUNKS = 20
"""The pressure itself is the median of this many chunk means: it follows the hand, not the grooves."""
FLAG_ON, FLAG_OFF = 3.0, 1.5
"""A pattern begins and ends at these multiples of the mean ..."""
SCATTERS = 7.0
"""... begins no lower than the mean and so many standard deviations of the envelope: a slow stroke over a
rough surface leaves the envelope nearly unaveraged, and three times the mean is then nothing special ..."""
FLOOR_ON_V, FLOOR_OFF_V = 0.040, 0.020
"""... and never below these (8 and 4 steps of the converter), V."""
REARM = 0.5
"""Within a pattern the next impulse needs the envelope to have fallen to this part of the last peak, then doubled."""
SHORTEST_PERIOD_M = 1.0e-3
PATTERN_S, PATTERN_M = 0.20, 5e-3
"""Beyond both, it is no pattern but another surface."""
CARRY_S = 1.0
"""A rest this short within one contact continues the stroke; a longer one starts the mean again."""


@dataclass(frozen=True, slots=True)
class RoughnessReading:
    """What one chunk of the texture signal told.

    Attributes:
        roughness_v: mean rectified signal without patterns, V.
        impulse: whether a groove or edge begins in this chunk.
        pattern: whether the mean is held.
        valid: whether `roughness_v` describes the surface being touched.
        saturated: whether the converter clipped; the chunk was not used.
        surface_changed: whether a pattern outlasted its limits and the mean was started again.
        envelope_v: mean rectified signal of this chunk, V.
    """

    roughness_v: float
    impulse: bool
    pattern: bool
    valid: bool
    saturated: bool
    surface_changed: bool
    envelope_v: float


class Roughness:
    """Roughness identification of one finger."""

    __slots__ = (
        "_armed",
        "_baseline",
        "_impulse_s",
        "_integral_v",
        "_leak",
        "_mean_v",
        "_pattern",
        "_pattern_m",
        "_pattern_s",
        "_peak_v",
        "_recent",
        "_seed",
        "_square",
        "_stroke_s",
        "_valley_v",
    )

    def __init__(self, leak_hz: float = LEAK_HZ) -> None:
        """Take the corner of the sensor's leaky integrator, Hz; 0 for a sensor with a true zero."""
        self._leak = 2.0 * math.pi * leak_hz / RATE_HZ
        self._integral_v = 0.0
        self._baseline: deque[float] = deque(maxlen=BASELINE_CHUNKS)
        self._recent: deque[float] = deque(maxlen=SEED_CHUNKS)
        self._seed = 0
        self._mean_v = 0.0
        self._square = 0.0
        self._pattern = False
        self._pattern_s = 0.0
        self._pattern_m = 0.0
        self._armed = True
        self._peak_v = 0.0
        self._valley_v = 0.0
        self._impulse_s = -math.inf
        self._stroke_s = -math.inf

    def step(
        self,
        t_s: float,
        chunk_v: NDArray[np.float64],
        mode: ExplorationMode,
        speed_m_s: float,
        force_n: float,
    ) -> RoughnessReading:
        """Take one chunk of the texture signal that ends at `t_s`.

        Args:
            t_s: time, s.
            chunk_v: consecutive samples at 2 kHz, V (normally 10).
            mode: exploration mode; only a stroke is judged.
            speed_m_s: stroke speed, m/s, >= 0.
            force_n: contact force, N; without contact the sensor's history is dropped.
        """
        count = len(chunk_v)
        dt_s = count / RATE_HZ
        if force_n < 0.05 and mode is ExplorationMode.FREE:
            self._integral_v = 0.0
            self._baseline.clear()
        summed = np.cumsum(chunk_v)
        restored = chunk_v + self._leak * (summed + self._integral_v)
        self._integral_v = (self._integral_v + float(summed[-1])) * (1.0 - 2.0 * math.pi * DRIFT_HZ * dt_s)
        middle_v = float(np.add.reduce(restored)) / count
        self._baseline.append(middle_v)
        if mode is not ExplorationMode.STROKING:
            self._pause(t_s, mode)
            return RoughnessReading(self._mean_v, False, False, self._seed >= SEED_CHUNKS, False, False, 0.0)
        level_v = sorted(self._baseline)[len(self._baseline) // 2]
        envelope_v = float(np.add.reduce(np.abs(restored - level_v))) / count
        self._stroke_s = t_s
        if not max(float(chunk_v.max()), -float(chunk_v.min())) < CLIP_V:
            valid = self._seed >= SEED_CHUNKS
            return RoughnessReading(self._mean_v, False, self._pattern, valid, True, False, envelope_v)
        self._recent.append(envelope_v)
        if self._seed < SEED_CHUNKS:
            self._seed += 1
            self._begin_mean()
            return RoughnessReading(self._mean_v, False, False, self._seed >= SEED_CHUNKS, False, False, envelope_v)
        impulse = self._watch_impulse(t_s, envelope_v, speed_m_s)
        changed = self._hold_or_average(envelope_v, speed_m_s, dt_s)
        return RoughnessReading(self._mean_v, impulse, self._pattern, True, False, changed, envelope_v)

    def _pause(self, t_s: float, mode: ExplorationMode) -> None:
        """Freeze the mean between strokes; forget it with the contact or after CARRY_S."""
        if mode is ExplorationMode.FREE or t_s - self._stroke_s > CARRY_S:
            self._seed = 0
            self._mean_v = 0.0
            self._recent.clear()
        self._pattern = False
        self._armed = True

    def _begin_mean(self) -> None:
        """Start from the last 50 ms, by ranks: one groove in them changes little."""
        ranked = sorted(self._recent)
        middle = ranked[len(ranked) * 2 // 5]
        spread = 2.0 * (middle - ranked[len(ranked) // 10])
        self._mean_v = middle
        self._square = spread * spread

    def _on_v(self) -> float:
        """Envelope above which a pattern begins, V."""
        return max(FLAG_ON * self._mean_v, self._mean_v + SCATTERS * math.sqrt(self._square), FLOOR_ON_V)

    def _watch_impulse(self, t_s: float, envelope_v: float, speed_m_s: float) -> bool:
        """Whether an impulse begins: over the threshold and, within a pattern, out of a valley."""
        on_v = self._on_v()
        if not self._armed:
            self._peak_v = max(self._peak_v, envelope_v)
            if envelope_v < max(REARM * self._peak_v, FLAG_OFF * self._mean_v):
                self._armed = True
                self._valley_v = envelope_v
            return False
        self._valley_v = min(self._valley_v, envelope_v)
        refractory_s = 0.5 * SHORTEST_PERIOD_M / max(speed_m_s, 1e-3)
        risen = not self._pattern or envelope_v > 2.0 * self._valley_v
        if envelope_v > on_v and risen and t_s - self._impulse_s > refractory_s:
            self._armed = False
            self._peak_v = envelope_v
            self._impulse_s = t_s
            return True
        return False

    def _hold_or_average(self, envelope_v: float, speed_m_s: float, dt_s: float) -> bool:
        """Eq. 6 with forgetting outside patterns; returns whether the surface changed."""
        if not self._pattern:
            if envelope_v > self._on_v():
                self._pattern = True
                self._pattern_s = self._pattern_m = 0.0
            else:
                part = 1.0 - math.exp(-dt_s / TAU_S)
                error_v = envelope_v - self._mean_v
                self._mean_v += part * error_v
                self._square += part * (error_v * error_v - self._square)
                if self._square > self._mean_v * self._mean_v:
                    # A homogeneous surface scatters by a quarter of its mean. This one by all of it: impulses have
                    # got in, and a threshold made of them would let them in for ever.
                    self._begin_mean()
            return False
        self._pattern_s += dt_s
        self._pattern_m += speed_m_s * dt_s
        if envelope_v < max(FLAG_OFF * self._mean_v, FLOOR_OFF_V):
            self._pattern = False
        elif self._pattern_s > PATTERN_S and self._pattern_m > PATTERN_M:
            self._begin_mean()
            self._pattern = False
            self._armed = True
            return True
        return False
