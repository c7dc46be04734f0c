"""Is a joint of the exoskeleton stuck, or its encoder? A living finger is never still.

It trembles, by some 0.02 mm at 8 to 11 Hz, and drifts; resting on something hard it still does, by less. So a height
that is the same to the encoder's count of 0.005 mm for STILL_S is not of a living finger, while there is one: while
the exoskeleton pushes it, or other fingers or the hand move. At the ends of its travel a finger may stand still.
"""

from collections.abc import Sequence

from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS

STILL_S = 1.5
"""Fingers of the simulated hand, in the air and on walls up to 1500 N/m, are still for 0.06 s at most; people vary."""
LIVELY_S = 0.25
"""A hand that moved within this is there: at least two periods of tremor."""
PUSHED_N = 0.3
STOP_M = 0.0099
"""Further from the middle of its travel a finger is at its stop."""
LONGEST_S = 0.010
"""Of a gap between two frames no more counts."""


class StuckJoints:
    """Watches five fingers of one hand.

    Attributes:
        stuck_s: how long each finger has been still while it should not have been, (5,), s.
    """

    def __init__(self, taking_part: Sequence[bool] = (True,) * len(FINGERS)) -> None:
        """Watch the fingers that are in the exoskeleton."""
        n = len(FINGERS)
        self.stuck_s = [0.0] * n
        self._taking_part = tuple(taking_part)
        self._z_m: Sequence[float] = ()
        self._pose_m: Sequence[float] = ()
        self._since_s = [LIVELY_S] * n
        self._hand_s = LIVELY_S
        """Since each finger's height has changed, and the hand's pose, s: at first there is nobody."""

    def step(self, dt_s: float, z_m: Sequence[float], pose_m: Sequence[float], pushed_n: Sequence[float]) -> None:
        """Take a frame of heights.

        Args:
            dt_s: since the frame before, s; not above 0 where that is not known.
            z_m: heights (5,), m, as they were read.
            pose_m: x and y of the hand, m.
            pushed_n: what the exoskeleton pushes each finger with, (5,), N.
        """
        passed_s = min(LONGEST_S, max(0.0, dt_s))
        before_m, self._z_m = self._z_m or z_m, z_m
        self._hand_s = 0.0 if pose_m != (self._pose_m or pose_m) else self._hand_s + passed_s
        self._pose_m = pose_m
        since_s, lively = self._since_s, 0
        for finger, height_m in enumerate(z_m):
            since_s[finger] = since = 0.0 if height_m != before_m[finger] else since_s[finger] + passed_s
            lively += since < LIVELY_S
        hand = self._hand_s < LIVELY_S
        for finger, since in enumerate(since_s):
            if since == 0.0 or not self._taking_part[finger] or abs(z_m[finger]) >= STOP_M:
                self.stuck_s[finger] = 0.0
            elif hand or pushed_n[finger] >= PUSHED_N or lively > (since < LIVELY_S):
                self.stuck_s[finger] += passed_s

    @property
    def faults(self) -> list[Fault]:
        """What is wrong with which finger; empty when all is well."""
        if max(self.stuck_s) < STILL_S:
            return []
        return [
            Fault(FaultCode.FINGER_STILL, FINGERS[finger], value=since_s, limit=STILL_S)
            for finger, since_s in enumerate(self.stuck_s)
            if since_s >= STILL_S
        ]
