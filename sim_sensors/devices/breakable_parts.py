"""Breakable parts of the simulated devices: each has no effect until it is broken, and can be mended."""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from common.buses.can_frames import SentFrame, database
from common.buses.thermometry import COUNT_MAX

ThermistorFault = Literal["open", "short", "frozen"]
PiezoFault = Literal["saturated", "clipped", "cut", "loose"]
EncoderFault = Literal["glitch", "stuck"]
ForceFault = Literal["frozen", "biased"]
FrameFault = Literal["counter", "crc"]
Place = tuple[float, float, NDArray[np.float64]]
"""Hand's x and y, m, and the heights of the fingertips (5,), m."""

DRIFT_M_S = 0.02
_BAUD_PER_BYTE = 10.0
_PIEZO_MAX, _OVERDRIVEN, _NOISE_COUNTS = 2047, 30, 1.6
_LONGEST_BURST_S = 0.05
_GLITCH_M, _GLITCHES = 0.006, 0.02
"""Jump of a glitching reading, m, and share of the readings that jump (10 a second at 500 Hz)."""
_BIAS_N = 1.5


class Thermistor:
    """Thermistor of a temperature sensor, as its converter reads it.

    Attributes:
        fault: `open` reads the top of the scale, `short` its bottom, `frozen` the last sound value; None: it is sound.
    """

    def __init__(self) -> None:
        self.fault: ThermistorFault | None = None
        self._last = 0

    def read(self, counts: int) -> int:
        """Return the converter's reading, 0..4095, where a sound thermistor would give `counts`."""
        if self.fault == "open":
            return COUNT_MAX
        if self.fault == "short":
            return 0
        if self.fault is None:
            self._last = counts
        return self._last


class Piezo:
    """Piezo element and amplifier of a texture sensor, as their converter reads them.

    Attributes:
        fault: `saturated` stays at the top of the scale, `clipped` has so high a gain that pressing overdrives it,
            `cut` reads 0, `loose` reads only the amplifier's noise; None: it is sound.
    """

    def __init__(self, seed: int = 0) -> None:
        self.fault: PiezoFault | None = None
        self._random = np.random.default_rng(seed)

    def read(self, counts: NDArray[np.int16]) -> NDArray[np.int16]:
        """Return the converter's readings, -2048..2047, where a sound element would give `counts`."""
        match self.fault:
            case None:
                return counts
            case "saturated":
                return np.full_like(counts, _PIEZO_MAX)
            case "clipped":
                return np.clip(_OVERDRIVEN * counts.astype(np.int32), -_PIEZO_MAX - 1, _PIEZO_MAX).astype(np.int16)
            case "cut":
                return np.zeros_like(counts)
            case "loose":
                return np.rint(_NOISE_COUNTS * self._random.standard_normal(counts.shape)).astype(np.int16)


class Encoder:
    """A finger's encoder.

    Attributes:
        fault: `glitch`: single readings jump, `stuck`: it repeats the last sound reading; None: it is sound.
        last: last sound reading, m.
    """

    def __init__(self, seed: int = 0) -> None:
        self.fault: EncoderFault | None = None
        self._random = np.random.default_rng(seed)
        self.last = 0.0

    def read(self, place_m: float) -> float:
        """Return the reading where a sound encoder would read `place_m`, m."""
        if self.fault != "stuck":
            self.last = place_m
        if self.fault == "glitch" and self._random.random() < _GLITCHES:
            return place_m - _GLITCH_M if place_m > 0.0 else place_m + _GLITCH_M
        return self.last


class ForceSensor:
    """A fingertip's force sensor.

    Attributes:
        fault: `frozen`: it repeats the last sound reading, `biased`: it reads 1.5 N too much; None: it is sound.
        last: last sound reading, N.
    """

    def __init__(self) -> None:
        self.fault: ForceFault | None = None
        self.last = 0.0

    def read(self, force_n: float) -> float:
        """Return the reading where a sound sensor would read `force_n`, N."""
        if self.fault != "frozen":
            self.last = force_n
        return self.last + _BIAS_N if self.fault == "biased" else self.last


def read_all(parts: Iterable[tuple[int, Encoder | ForceSensor]], values: list[float]) -> None:
    """Replace the sound values by the readings of the parts, in place; each part comes with its index in `values`."""
    for number, part in parts:
        if part.fault is None:
            part.last = values[number]
        else:
            values[number] = part.read(values[number])


class Transmitter:
    """Transmitter of a CAN node.

    Attributes:
        damage: kind of damage and share of the frames damaged, 0..1; None: it is sound. `counter` repeats the bytes of
            the frame before, `crc` makes the CRC wrong in frames that have one.
    """

    def __init__(self) -> None:
        self.damage: tuple[FrameFault, float] | None = None
        self._random = np.random.default_rng(0)
        self._last: dict[int, bytes] = {}
        self._with_crc = {m.frame_id for m in database().messages if any(s.name == "crc" for s in m.signals)}

    def send(self, frames: list[SentFrame]) -> list[SentFrame]:
        """Return the frames as they reach the bus."""
        if self.damage is None:
            self._last.update(frames)
            return frames
        return [self._damaged(*frame, *self.damage) for frame in frames]

    def _damaged(self, frame_id: int, sound: bytes, fault: FrameFault, share: float) -> SentFrame:
        before = self._last.get(frame_id, sound)
        self._last[frame_id] = sound
        if self._random.random() >= share:
            return frame_id, sound
        if fault == "counter":
            self._last[frame_id] = before
            return frame_id, before
        return frame_id, sound[:7] + bytes((sound[7] ^ 0xFF,)) if frame_id in self._with_crc else sound


class Servos:
    """The telemanipulator's drives. Broken drives hold or drift and ignore the set-points.

    Attributes:
        jammed: indices of the fingers that hold their height, independent of the other fingers.
    """

    def __init__(self) -> None:
        self.jammed: set[int] = set()
        self._drift_m_s: float | None = None
        self._last_s = 0.0
        self._last: Place | None = None

    def disobey(self, drift_m_s: float = 0.0) -> None:
        """From the next step on, hold the last set-point, or drift from it along x at `drift_m_s`, m/s."""
        self._drift_m_s = drift_m_s

    def mend(self) -> None:
        """Follow the set-points again."""
        self._drift_m_s = None

    def setpoint_m(self, now_s: float, asked: Place) -> Place:
        """Return the position that the drives follow at `now_s` when `asked` is commanded."""
        if self._drift_m_s is None or self._last is None:
            going = asked[0], asked[1], asked[2].copy()
        else:
            x_m, y_m, z_m = self._last
            going = x_m + self._drift_m_s * (now_s - self._last_s), y_m, z_m
        if self._last is not None:
            for finger in self.jammed:
                going[2][finger] = self._last[2][finger]
        self._last_s, self._last = now_s, going
        return going


class Babble:
    """Transmitter that fills its line with random bytes between its own frames."""

    def __init__(self, baud: float) -> None:
        self._bytes_per_s = baud / _BAUD_PER_BYTE
        self._random = np.random.default_rng(0)
        self._sent_s: float | None = None

    def mix(self, now_s: float, output: bytes) -> bytes:
        """Return `output` after the noise bytes that fill the line's capacity since the last call."""
        since_s = 0.0 if self._sent_s is None else min(_LONGEST_BURST_S, max(0.0, now_s - self._sent_s))
        room = int(since_s * self._bytes_per_s) - len(output) - 1
        self._sent_s = now_s
        if room <= 0:
            return output
        # The zero byte ends the noise, so that the frames behind it are whole.
        return self._random.bytes(room) + b"\0" + output


@dataclass(slots=True)
class Hang:
    """Hang of the whole process for a given time.

    Attributes:
        sleep: blocks the process for a number of seconds.
    """

    sleep: Callable[[float], None] = time.sleep
    _due_s: float = 0.0

    def begin(self, seconds: float) -> None:
        """Hang for `seconds` at the next `pause`, so that the command is answered first."""
        self._due_s = seconds

    def pause(self) -> None:
        """Block if a hang is due; called once a step."""
        if self._due_s > 0.0:
            seconds, self._due_s = self._due_s, 0.0
            self.sleep(seconds)
