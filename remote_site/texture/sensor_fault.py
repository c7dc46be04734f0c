"""Diagnoses faults of a texture sensor from its signal and the force; a fault has a name and ends by itself.

    saturated       every sample is at one end of the range
    clipped         some samples are at an end of the range: the sensor is pressed or shaken beyond its range
    disconnected    no sample differs from the next: a connected sensor has noise
    noise only      the signal stays noise when the finger lands or lifts: the sensor is loose
    noisy           the signal moves fast without contact: hum, or a loose wire
    too few samples fewer samples come than the rate says: the sensor is slower, or its line loses some

"Noise only" needs a change of force by a finger that does not stroke, so that it is diagnosed at the next contact. It
ends when the signal shows any course, or becomes louder than its noise, whatever the finger does. A force sensor that
jumps may have reported a contact that never was. The diagnosis is independent of units and delays. Force and texture
come from two devices, and on a busy host either may arrive 0.1 s after the other. The test therefore does not compare
the signal with the force. It only asks whether the signal has any course: in noise, a value does not predict the next.
A sensor that moves with something other than its finger remains undetected.
"""

import math
from collections import deque
from collections.abc import Sequence
from itertools import islice
from statistics import median

import numpy as np

from remote_site.texture.tip_path import LEAK_HZ, RATE_HZ

SATURATED = "saturated: stuck at the end of its range"
CLIPPED = "clipped: beyond its range again and again"
DISCONNECTED = "disconnected: no noise at all"
NOISE_ONLY = "noise only: does not follow the force"
NOISY = "noisy: moves without contact"
TOO_FEW = "too few samples: slower than its rate, or a line that loses some"
RAIL_V = 9.98
"""Magnitude from which a sample is at an end of the converter's range, V."""
STILL_V = 1e-3
"""Span below which a signal has no noise, V; less than a step of the converter."""
SATURATED_S, FLAT_S, CLIPPED_S, FOLLOWS_S = 0.05, 0.10, 0.50, 0.40
"""Durations over which each fault is judged, s: saturated, disconnected, clipped, noise only."""
COUNTED_S = 1.0
"""Signal of which the duration is compared with the time that it took, s."""
TOO_SLOW, ENOUGH = 0.90, 0.95
"""Rates of samples over RATE_HZ below which they are too few, and from which they are enough again.

A path is shorter by the same factor. Firmware keeps to ENOUGH.
"""
PAUSE_S = 0.05
"""Time between two blocks from which on the signal has paused, s; then counting begins again."""
CLIPPED_PART = 0.01
"""Largest fraction of samples at the ends of the range in a sound signal."""
_CLIPPED_MOST = CLIPPED_PART * CLIPPED_S * RATE_HZ
PRESSED_N = 0.25
"""Minimum change of the force after the integrator for the test for noise only, N."""
LATE_S = 0.15
"""Maximum delay between force and texture, in either direction, s."""
NOISE_STEP = 0.5
"""Minimum mean square of the signal's steps, over twice its variance, that shows noise.

White noise has 1 +- 0.11 in 80 blocks, and hum of 50 Hz has 1. A fingertip that bounces at 25 Hz has 0.3. A fingertip
that rests or is pressed has less.
"""

FREE_S = 0.3
"""Time after which the integrator has forgotten a contact, s."""
NOISE_RATIO = 10.0
"""Curvature without contact over that of the calibrated noise from which on the identification fails."""
RMS_OF_MEDIAN = 1.4826
"""Rms of a normal curvature over its median magnitude, which a knock at the table does not change."""
WATCH_EVERY = 4
"""Number of blocks between two tests for noise: 20 ms of FOLLOWS_S."""
LOUDER = 4.0
"""Ratio of the noise's mean squares that ends the fault; a stroke over plain plastic reaches it, noise does not."""


class SensorFault:
    """Monitors one sensor, block by block.

    Attributes:
        fault: name of the fault; None while the sensor is sound.
    """

    def __init__(self, samples: int, rail_v: float = RAIL_V, noise_v: float = math.inf) -> None:
        """Begin; a block has this number of samples, and from the magnitude `rail_v`, V, a sample is at an end.

        `noise_v` is the calibrated noise of a sample, rms, V; infinite or 0 if it is not known.
        """
        self._rail_v = rail_v
        self._loudest_v = NOISE_RATIO * (noise_v or math.inf) * math.sqrt(1.5 / samples) / RMS_OF_MEDIAN
        self._noisy = False
        self.fault: str | None = None
        self._samples = samples
        block_s = self._block_s = samples / RATE_HZ
        self._keep = math.exp(-2.0 * math.pi * LEAK_HZ * samples / RATE_HZ)
        self._noise_v2: float | None = None
        """Mean square of the steps of a signal that is noise only."""
        self._force_n: float | None = None
        self._count = 0
        self._stuck = 0
        """Number of latest blocks with every sample at an end of the range."""
        clipped = math.ceil(CLIPPED_S / block_s)
        self._railed = deque([0] * clipped, maxlen=clipped)
        """Number of samples at the ends of the range in each block of CLIPPED_S."""
        self._clipped = 0
        """Sum of `_railed`."""
        self._spans_v: deque[tuple[float, float]] = deque(maxlen=round(FLAT_S / block_s))
        """Lowest and highest sample of each block of FLAT_S, V."""
        follows = round(FOLLOWS_S / block_s)
        self._means_v: deque[float] = deque(maxlen=follows)
        """Mean of the signal in each block of FOLLOWS_S, V."""
        self._presses_n = deque([0.0], maxlen=follows)
        """Force after the integrator in each block of FOLLOWS_S, N."""
        self._rested = 0
        """Number of latest blocks in which the finger does not stroke."""
        self._free = 0
        """Number of latest blocks without contact."""
        self._ends_s: deque[float] = deque(maxlen=1 + round(COUNTED_S / block_s))
        """End of each block since the last pause, in COUNTED_S, s."""

    def step(
        self, end_s: float, samples_v: Sequence[float], force_n: float, resting: bool, free: bool = False
    ) -> str | None:
        """Take the next samples, V, which end at `end_s`, s, and the contact force, N; return the present fault.

        In a `resting` finger, which does not stroke, only the force can move the signal; in a `free` one nothing can.
        """
        ends_s = self._ends_s
        if ends_s and end_s - ends_s[-1] > PAUSE_S:
            ends_s.clear()
        ends_s.append(end_s)
        slowest = ENOUGH if self.fault == TOO_FEW else TOO_SLOW
        too_few = len(ends_s) == ends_s.maxlen and slowest * (end_s - ends_s[0]) > COUNTED_S
        before_n, self._force_n = self._force_n, force_n
        changed_n = 0.0 if before_n is None else force_n - before_n
        low_v, high_v = min(samples_v), max(samples_v)
        railed = 0
        rail_v = self._rail_v
        if high_v >= rail_v or low_v <= -rail_v:
            railed = sum(not -rail_v < v < rail_v for v in samples_v)
        self._stuck = self._stuck + 1 if railed == self._samples else 0
        self._clipped += railed - self._railed[0]
        self._railed.append(railed)
        self._spans_v.append((low_v, high_v))
        self._means_v.append(sum(samples_v) / self._samples)
        self._presses_n.append(self._keep * (self._presses_n[-1] + changed_n))
        self._rested = self._rested + 1 if resting else 0
        self._free = self._free + 1 if free else 0
        self._count += 1
        if self._count % WATCH_EVERY == 0:
            if resting or self._noise_v2 is not None:
                self._watch_signal()
            if self._free * self._block_s >= FREE_S + FOLLOWS_S:
                self._watch_noise()
        span_v = high_v - low_v
        quiet = self._noise_v2 is None and not self._noisy
        sound = not railed and quiet and self._clipped <= _CLIPPED_MOST and span_v >= STILL_V
        self.fault = None if sound else self._name(span_v)
        if too_few and self.fault is None:
            self.fault = TOO_FEW
        return self.fault

    def _name(self, span_v: float) -> str | None:
        if self._stuck and self._stuck >= min(round(SATURATED_S / self._block_s), self._count):
            return SATURATED
        if self._clipped > _CLIPPED_MOST:
            return CLIPPED
        if span_v < STILL_V:
            lows_v, highs_v = zip(*self._spans_v, strict=True)
            if max(highs_v) - min(lows_v) < STILL_V:
                return DISCONNECTED
        if self._noise_v2 is not None:
            return NOISE_ONLY
        return NOISY if self._noisy else None

    def _pressed(self) -> bool:
        """Return whether the force changed in FOLLOWS_S, without LATE_S at both ends."""
        late = round(LATE_S / self._block_s)
        pressed_n = list(islice(self._presses_n, late, len(self._presses_n) - late))
        return max(pressed_n) - min(pressed_n) >= PRESSED_N

    def _watch_noise(self) -> None:
        """Test whether the signal moves without contact: by the curvature of three blocks, as at 40 mm/s."""
        means_v = np.array(self._means_v)
        curvature_v = means_v[1:-1] - 0.5 * (means_v[:-2] + means_v[2:])
        self._noisy = median(np.abs(curvature_v).tolist()) > self._loudest_v

    def _watch_signal(self) -> None:
        """Test for noise only after a change of force; while the fault lasts, test whether it ends."""
        follows = len(self._means_v)
        if self._means_v.maxlen != follows:
            return
        if self._noise_v2 is None and (self._rested < follows or not self._pressed()):
            return
        signal_v = np.array(self._means_v)
        steps_v, around_v = signal_v[1:] - signal_v[:-1], signal_v - signal_v.sum() / follows
        steps_v2, variance_v2 = float(steps_v @ steps_v) / (follows - 1), float(around_v @ around_v) / follows
        if steps_v2 < NOISE_STEP * 2.0 * variance_v2:
            self._noise_v2 = None
        elif self._noise_v2 is None:
            self._noise_v2 = steps_v2
        elif steps_v2 > LOUDER * self._noise_v2:
            self._noise_v2 = None
