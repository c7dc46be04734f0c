"""Replaces readings of an encoder that jumped further than its joint can move, and finds faulty encoders.

A single glitch returns by itself. Until then the last believed place replaces the reading, as for a lost frame.
Repeated glitches, or a place that does not return, are a fault.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from common.faults.fault import Fault, FaultCode
from common.timing.timeouts import FRAME_S

FINGER_M_S = 2.0
"""Maximum speed of a finger, m/s: 10 N of the exoskeleton and 10 N of the finger act on 0.1 kg over 10 mm."""
HAND_M_S = 3.0
"""Maximum speed of an exploring hand, m/s."""
RETURN_S = 0.005
"""Maximum duration of a glitch, s; a longer one is a fault."""
GLITCHES, WINDOW_S = 3, 1.0
"""Maximum number of glitches within WINDOW_S, s; more are a fault."""
UNSEEN_S = 0.100
"""Maximum gap between two frames, s, across which places are compared."""


@dataclass(slots=True)
class _Suspect:
    """An encoder with recent glitches.

    Attributes:
        glitches_s: times of the glitches, s.
        away_s: duration of the present glitch, s; 0 without one.
    """

    glitches_s: deque[float] = field(default_factory=lambda: deque(maxlen=GLITCHES + 1))
    away_s: float = 0.0


class EncoderGlitches:
    """Encoders that are read together, in one frame.

    Attributes:
        faults: faults of all frames since `begin`.
        refused: number of replaced readings.
    """

    def __init__(self, names: Sequence[str], fastest_m_s: float) -> None:
        """Watch encoders with these names in faults, and a maximum speed, m/s."""
        self.faults: list[Fault] = []
        self.refused = 0
        self._names = names
        self._fastest_m_s = fastest_m_s
        self._place_m: tuple[float, ...] = ()
        self._sent_s = math.nan
        self._suspects: dict[int, _Suspect] = {}

    def begin(self) -> None:
        """Forget the faults of earlier frames; called before the frames of a tick."""
        self.faults = []

    def step(self, sent_s: float, read_m: tuple[float, ...]) -> tuple[float, tuple[float, ...]]:
        """Take finite readings of a frame, m; return the time since the last frame, s, and the places to act on, m.

        `sent_s` is the bus's clock, s, which a delay of site or gateway does not change.
        """
        dt_s, self._sent_s = sent_s - self._sent_s, sent_s
        if not 0.0 < dt_s <= UNSEEN_S:  # the first frame, the first for long, or the first of another gateway
            self._suspects.clear()
            self._place_m = read_m
            return dt_s, read_m
        reach_m = self._fastest_m_s * (dt_s if dt_s > FRAME_S else FRAME_S)
        near = [-reach_m <= read - place <= reach_m for read, place in zip(read_m, self._place_m, strict=True)]
        if self._suspects or False in near:
            read_m = tuple([self._judge(n, dt_s, read_m[n], near=near[n]) for n in range(len(near))])
        self._place_m = read_m
        return dt_s, read_m

    def _judge(self, number: int, dt_s: float, read_m: float, *, near: bool) -> float:
        """Return the place to act on of one encoder."""
        suspect = self._suspects.get(number)
        if suspect is None:
            if near:
                return read_m
            suspect = self._suspects[number] = _Suspect()
        place_m = self._place_m[number]
        if near:
            suspect.away_s = 0.0
            place_m = read_m
        elif suspect.away_s + dt_s < RETURN_S:
            if suspect.away_s == 0.0:
                suspect.glitches_s.append(self._sent_s)
            suspect.away_s += dt_s
            self.refused += 1
        else:
            del self._suspects[number]  # the fault is reported, and the new place is believed
            jumped_mm = abs(read_m - place_m) * 1e3
            self.faults.append(Fault(FaultCode.ENCODER_JUMPED, self._names[number], value=jumped_mm))
            return read_m
        recent = [t_s for t_s in suspect.glitches_s if self._sent_s - t_s <= WINDOW_S]
        if len(recent) > GLITCHES:
            times, most = float(len(recent)), float(GLITCHES)
            self.faults.append(Fault(FaultCode.ENCODER_JUMPS, self._names[number], value=times, limit=most))
        elif not recent:
            del self._suspects[number]
        return place_m
