"""Has an encoder jumped? A reading that nothing could have reached since the one before is not acted on.

A glitch comes back by itself: for as long as it may take, the last place that was believed stands for the reading, as
it does where a frame is lost. Glitches again and again, or a place that does not come back, are a fault.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from common.faults.fault import Fault, FaultCode
from common.timing.timeouts import FRAME_S

FINGER_M_S = 2.0
"""No finger in the exoskeleton is faster: 10 N of it and 10 N of the finger's own on 0.1 kg over half of its 20 mm."""
HAND_M_S = 3.0
"""No hand that explores is faster."""
RETURN_S = 0.005
"""A reading that is not back by then does not come back."""
GLITCHES, WINDOW_S = 3, 1.0
"""More of them in this time are a fault."""
UNSEEN_S = 0.100
"""After a longer gap a place may be anywhere."""


@dataclass(slots=True)
class _Suspect:
    """An encoder that has jumped lately: when, s, and for how long it has been away, s; 0 when it is back."""

    glitches_s: deque[float] = field(default_factory=lambda: deque(maxlen=GLITCHES + 1))
    away_s: float = 0.0


class EncoderGlitches:
    """Encoders that are read together, in one frame.

    Attributes:
        faults: what is wrong with which as of the last frame; empty when all is well.
        refused: readings that were not acted on.
    """

    def __init__(self, names: Sequence[str], fastest_m_s: float) -> None:
        """What each measures, as faults name it, and how fast it can move, m/s."""
        self.faults: list[Fault] = []
        self.refused = 0
        self._names = names
        self._fastest_m_s = fastest_m_s
        self._place_m: tuple[float, ...] = ()
        self._sent_s = math.nan
        self._suspects: dict[int, _Suspect] = {}

    def step(self, sent_s: float, read_m: tuple[float, ...]) -> tuple[float, tuple[float, ...]]:
        """Take a frame's readings, m; returns the time since the frame before, s, and the places to act on, m.

        Args:
            sent_s: when the frame was on the bus, by the bus's clock, s: a site that stood still reads late, and
                a gateway that did sends late, but neither makes a finger fast.
            read_m: what each encoder reads, finite.
        """
        dt_s, self._sent_s = sent_s - self._sent_s, sent_s
        self.faults = []
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
        """The place to act on, of one encoder."""
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
            del self._suspects[number]  # it begins anew from there: the fault is told
            jumped_mm = abs(read_m - place_m) * 1e3
            self.faults.append(Fault(FaultCode.ENCODER_JUMPED, self._names[number], value=jumped_mm))
            return read_m
        lately = [t_s for t_s in suspect.glitches_s if self._sent_s - t_s <= WINDOW_S]
        if len(lately) > GLITCHES:
            times, most = float(len(lately)), float(GLITCHES)
            self.faults.append(Fault(FaultCode.ENCODER_JUMPS, self._names[number], value=times, limit=most))
        elif not lately:
            del self._suspects[number]
        return place_m
