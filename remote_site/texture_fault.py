"""What is wrong with a texture sensor, from its signal and the force alone: a fault has a name, and ends by itself.

    saturated       every sample is at one end of the range
    clipped         now and again samples are: it is pressed or shaken beyond its range
    disconnected    no sample differs from the next: a sensor that is there has noise
    noise only      it stays noise when the finger comes down, or lifts: loose

The last needs a change of force by a finger that does not stroke: it is told at the next contact. It ends when the
signal goes anywhere, or becomes louder than its noise, whatever the finger does: a force sensor that jumps may have
told of a contact that there was not. Neither units nor delays matter to it: force and texture come from two devices,
and on a busy host either may come 0.1 s after the other. So it is not asked whether the signal has the shape of the
force, only whether it has any: in noise a value tells nothing of the next. A sensor that moves with something else than
its finger is not found out.
"""

import math
from collections import deque
from collections.abc import Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np

from remote_site.tip_path import LEAK_HZ, RATE_HZ

SATURATED = "saturated: stuck at the end of its range"
CLIPPED = "clipped: beyond its range again and again"
DISCONNECTED = "disconnected: no noise at all"
NOISE_ONLY = "noise only: does not follow the force"
RAIL_V = 9.98
"""The ends of the converter's range are beyond this, V."""
STILL_V = 1e-3
"""A signal that stays within this, less than a converter's step, has no noise, V."""
SATURATED_S, FLAT_S, CLIPPED_S, FOLLOWS_S = 0.05, 0.10, 0.50, 0.40
"""How long each is watched, s."""
CLIPPED_PART = 0.01
"""Part of the samples at the ends of the range that is no accident."""
PRESSED_N = 0.25
"""Force, behind the integrator, that has to change before it is judged whether the signal follows, N."""
LATE_S = 0.15
"""Either of force and texture may come this much after the other, s."""
NOISE_STEP = 0.5
"""Mean square of the signal's steps, over twice its variance, from which on it is noise. White noise has 1 +- 0.11 in
80 blocks, hum of 50 Hz has 1; a fingertip that bounces at 25 Hz has 0.3, one that rests or is pressed less."""

WATCH_EVERY = 4
"""Blocks from one look whether the signal follows the force to the next: 20 ms of FOLLOWS_S."""
LOUDER = 4.0
"""Noise does not become so much more by itself, in its mean square; by a stroke over plain plastic it does."""


class _Block(NamedTuple):
    low_v: float
    high_v: float
    railed: int
    samples: int
    mean_v: float
    pressed_n: float
    resting: bool


class TextureFault:
    """Watches one sensor, block by block.

    Attributes:
        fault: its name; None while the sensor is sound.
    """

    __slots__ = ("_blocks", "_count", "_force_n", "_noise_v2", "_pressed_n", "_railed", "fault")

    def __init__(self, block_s: float) -> None:
        """Take the length of a block, s."""
        self.fault: str | None = None
        self._blocks: deque[_Block] = deque(maxlen=math.ceil(CLIPPED_S / block_s))
        self._noise_v2: float | None = None
        """Mean square of the steps of a signal that is noise only."""
        self._force_n: float | None = None
        self._pressed_n = 0.0
        self._railed = 0
        self._count = 0

    def step(self, samples_v: Sequence[float], force_n: float, resting: bool) -> str | None:
        """Take the next block; return the fault there is now.

        Args:
            samples_v: samples, V.
            force_n: contact force, N.
            resting: whether the finger does not stroke: then force is all that can move the signal.
        """
        count = len(samples_v)
        before_n, self._force_n = self._force_n, force_n
        if before_n is not None:
            keep = math.exp(-2.0 * math.pi * LEAK_HZ * count / RATE_HZ)
            self._pressed_n = keep * (self._pressed_n + force_n - before_n)
        low_v, high_v = min(samples_v), max(samples_v)
        railed = sum(not -RAIL_V < v < RAIL_V for v in samples_v) if high_v >= RAIL_V or low_v <= -RAIL_V else 0
        mean_v = sum(samples_v) / count
        self._blocks.append(_Block(low_v, high_v, railed, count, mean_v, self._pressed_n, resting))
        self._railed = sum(block.railed for block in self._blocks) if self._railed or railed else 0
        self._count += 1
        if self._count % WATCH_EVERY == 0 and (resting or self._noise_v2 is not None):
            self._watch_signal(count / RATE_HZ)
        self.fault = self._name(count / RATE_HZ)
        return self.fault

    def _name(self, block_s: float) -> str | None:
        block = self._blocks[-1]
        if block.railed == block.samples and all(b.railed == b.samples for b in self._lately(SATURATED_S, block_s)):
            return SATURATED
        if self._railed > CLIPPED_PART * CLIPPED_S * RATE_HZ:
            return CLIPPED
        if block.high_v - block.low_v < STILL_V:
            flat = self._lately(FLAT_S, block_s)
            if max(b.high_v for b in flat) - min(b.low_v for b in flat) < STILL_V:
                return DISCONNECTED
        return None if self._noise_v2 is None else NOISE_ONLY

    def _lately(self, seconds: float, block_s: float) -> list[_Block]:
        """The last blocks, as many as there are."""
        wanted = round(seconds / block_s)
        return list(islice(self._blocks, max(0, len(self._blocks) - wanted), None))

    def _pressed(self, first: int, late: int) -> bool:
        """Whether the force changed between the blocks from `first` on, without the `late` ones at either end."""
        pressed_n = [block.pressed_n for block in islice(self._blocks, first + late, len(self._blocks) - late)]
        return max(pressed_n) - min(pressed_n) >= PRESSED_N

    def _watch_signal(self, block_s: float) -> None:
        """Whether the signal went anywhere, where the force did; also where that is not known, once it did not."""
        first = len(self._blocks) - round(FOLLOWS_S / block_s)
        if first < 0:
            return
        if self._noise_v2 is None and not self._pressed(first, round(LATE_S / block_s)):
            return
        blocks = self._lately(FOLLOWS_S, block_s)
        if self._noise_v2 is None and not all(block.resting for block in blocks):
            return
        signal = np.array([block.mean_v for block in blocks])
        steps_v2 = float(np.mean(np.diff(signal) ** 2))
        if steps_v2 < NOISE_STEP * 2.0 * float(np.var(signal)):
            self._noise_v2 = None
        elif self._noise_v2 is None:
            self._noise_v2 = steps_v2
        elif steps_v2 > LOUDER * self._noise_v2:
            self._noise_v2 = None
