"""Has an encoder jumped? A reading that nothing could have reached since the one before is not acted on.

A glitch comes back by itself: for as long as it may take, the last place that was believed stands for the reading, as
it does where a frame is lost. Glitches again and again, or a place that does not come back, are a fault.
"""

import math
from collections import deque
from collections.abc import Sequence

FINGER_M_S = 2.0
"""No finger in the exoskeleton is faster: 10 N of it and 10 N of the finger's own on 0.1 kg, over half of its 20 mm."""
HAND_M_S = 3.0
"""No hand that explores is faster."""
FRAME_S = 0.002
"""Encoders are read at 500 Hz; two readings are at least this far apart."""
RETURN_S = 0.006
"""A reading that is not back by then does not come back."""
GLITCHES, WINDOW_S = 3, 1.0
"""More of them in this time are a fault."""
UNSEEN_S = 0.100
"""After a longer gap a place may be anywhere."""


class EncoderJumps:
    """One encoder: `step` gives the place to act on.

    Attributes:
        fault: what is wrong as of the last reading; empty when nothing is.
        refused: readings that were not acted on.
    """

    __slots__ = ("_away_s", "_fastest_m_s", "_glitches_s", "_place_m", "_t_s", "fault", "refused")

    def __init__(self, fastest_m_s: float) -> None:
        """What it measures moves at most this fast, m/s."""
        self.fault = ""
        self.refused = 0
        self._fastest_m_s = fastest_m_s
        self._place_m = math.nan
        self._t_s = self._away_s = 0.0
        self._glitches_s: deque[float] = deque(maxlen=GLITCHES + 1)

    def step(self, dt_s: float, read_m: float) -> float:
        """Take a reading, m; returns the place to act on, m.

        Args:
            dt_s: time since the reading before, s; not above 0 where that is not known.
            read_m: the reading, finite.
        """
        if not 0.0 < dt_s <= UNSEEN_S or math.isnan(self._place_m):
            self._place_m, self._away_s, self.fault = read_m, 0.0, ""
            self._glitches_s.clear()
            return read_m
        self._t_s += dt_s
        jump_m = abs(read_m - self._place_m)
        if jump_m <= self._fastest_m_s * max(dt_s, FRAME_S):
            self._place_m, self._away_s = read_m, 0.0
        elif self._away_s == 0.0 and dt_s < RETURN_S:
            self._away_s = FRAME_S
            self._glitches_s.append(self._t_s)
            self.refused += 1
        elif self._away_s + dt_s < RETURN_S:
            self._away_s += dt_s
            self.refused += 1
        else:
            self._place_m, self._away_s = read_m, 0.0
            self.fault = f"encoder jumped by {jump_m * 1e3:.1f} mm"
            return read_m
        often = len(self._glitches_s) > GLITCHES and self._t_s - self._glitches_s[0] <= WINDOW_S
        self.fault = f"encoder jumps: {len(self._glitches_s)} times in {WINDOW_S:g} s" if often else ""
        return self._place_m


class Encoders:
    """Encoders that are read together, in one frame."""

    def __init__(self, names: Sequence[str], fastest_m_s: float) -> None:
        """What each measures, for people, and how fast it can move, m/s."""
        self._names = names
        self._encoders = [EncoderJumps(fastest_m_s) for _ in names]
        self._sent_s = math.nan

    def step(self, sent_s: float, read_m: Sequence[float]) -> tuple[float, list[float]]:
        """Take a frame's readings, m; returns the time since the frame before, s, and the places to act on, m.

        Args:
            sent_s: when the frame was on the bus, by the bus's clock, s: a site that stood still reads late, and
                a gateway that did sends late, but neither makes a finger fast.
            read_m: what each encoder reads, finite.
        """
        dt_s, self._sent_s = sent_s - self._sent_s, sent_s
        return dt_s, [encoder.step(dt_s, read) for encoder, read in zip(self._encoders, read_m, strict=True)]

    @property
    def faults(self) -> list[str]:
        """What is wrong with which; empty when all is well."""
        return [f"{name}: {each.fault}" for name, each in zip(self._names, self._encoders, strict=True) if each.fault]
