"""Parts of the simulated devices that can break: each does nothing until it is broken, and can be mended."""

import time
from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from common.thermometry import COUNT_MAX

ThermistorFault = Literal["open", "short", "frozen"]
Place = tuple[float, float, NDArray[np.float64]]
"""Hand's x and y, m, and the heights of the fingertips (5,), m."""

DRIFT_M_S = 0.02
_BAUD_PER_BYTE = 10.0
_LONGEST_BURST_S = 0.05


class Thermistor:
    """A temperature sensor's resistor, as its converter sees it.

    Attributes:
        fault: `open` reads the top of the scale, `short` its bottom, `frozen` what it read last; None: it is sound.
    """

    def __init__(self) -> None:
        self.fault: ThermistorFault | None = None
        self._last = 0

    def read(self, counts: int) -> int:
        """What the converter reads where a sound resistor would give `counts`, 0..4095."""
        if self.fault == "open":
            return COUNT_MAX
        if self.fault == "short":
            return 0
        if self.fault is None:
            self._last = counts
        return self._last


class Servos:
    """The telemanipulator's drives. Broken, they hold or move by themselves, and the set-points are nothing to them."""

    def __init__(self) -> None:
        self._drift_m_s: float | None = None
        self._last_s = 0.0
        self._last: Place | None = None

    def disobey(self, drift_m_s: float = 0.0) -> None:
        """From the next step on, hold the set-point followed last, or leave it along x at a speed, m/s."""
        self._drift_m_s = drift_m_s

    def mend(self) -> None:
        """Follow the set-points again."""
        self._drift_m_s = None

    def setpoint_m(self, now_s: float, asked: Place) -> Place:
        """Where they really go at `now_s` when they are sent to `asked`."""
        if self._drift_m_s is None or self._last is None:
            going = asked[0], asked[1], asked[2].copy()
        else:
            x_m, y_m, z_m = self._last
            going = x_m + self._drift_m_s * (now_s - self._last_s), y_m, z_m
        self._last_s, self._last = now_s, going
        return going


class Babble:
    """A transmitter that fills its line with random bytes, and says what it has to say in between."""

    def __init__(self, baud: float) -> None:
        self._bytes_per_s = baud / _BAUD_PER_BYTE
        self._random = np.random.default_rng(0)
        self._sent_s: float | None = None

    def mix(self, now_s: float, output: bytes) -> bytes:
        """`output` with as much noise before it as the line has carried since the last call."""
        since_s = 0.0 if self._sent_s is None else min(_LONGEST_BURST_S, max(0.0, now_s - self._sent_s))
        room = int(since_s * self._bytes_per_s) - len(output) - 1
        self._sent_s = now_s
        if room <= 0:
            return output
        # The zero byte ends the noise, so that the frames behind it are whole.
        return self._random.bytes(room) + b"\0" + output


class Hang:
    """A process that now and then does nothing at all."""

    def __init__(self, sleep: Callable[[float], None] = time.sleep) -> None:
        self._sleep = sleep
        self._due_s = 0.0

    def begin(self, seconds: float) -> None:
        """Hang for that long at the next `pause`: whoever asked is answered before."""
        self._due_s = seconds

    def pause(self) -> None:
        """Called once a step; blocks if a hang is due."""
        if self._due_s > 0.0:
            seconds, self._due_s = self._due_s, 0.0
            self._sleep(seconds)
