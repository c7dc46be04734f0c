"""Finds a stuck joint of the exoskeleton, or a stuck encoder: a living finger is never still.

A finger trembles by about 0.02 mm at 8 to 11 Hz and drifts, less so while it rests on something hard. A height that
stays within the encoder's count of 0.005 mm for STILL_S is therefore a fault while a hand is present. It is present
while the exoskeleton pushes the finger, or other fingers or the hand move. At an end of its travel a finger may be
still.
"""

from collections.abc import Sequence

from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS

STILL_S = 1.5
"""Duration of stillness that is a fault, s. The simulated hand is still for at most 0.06 s; people vary."""
LIVELY_S = 0.25
"""Maximum time since the last movement of a hand that is present, s: at least two periods of tremor."""
PUSHED_N = 0.3
"""Force from which on the exoskeleton pushes a finger, N."""
STOP_M = 0.0099
"""Distance from the middle of its travel from which on a finger is at its stop, m."""
LONGEST_S = 0.010
"""Maximum time that counts between two frames, s."""


class StuckJoints:
    """Watches five fingers of one hand.

    Attributes:
        stuck_s: duration for which each finger was still although it should move, (5,), s.
    """

    def __init__(self, taking_part: Sequence[bool] = (True,) * len(FINGERS)) -> None:
        n = len(FINGERS)
        self.stuck_s = [0.0] * n
        self._taking_part = tuple(taking_part)
        self._z_m: Sequence[float] = ()
        self._pose_m: Sequence[float] = ()
        self._since_s = [LIVELY_S] * n
        self._hand_s = LIVELY_S
        """Time since the last change of each height, and of the hand's pose, s; at first no hand is present."""

    def step(self, dt_s: float, z_m: Sequence[float], pose_m: Sequence[float], pushed_n: Sequence[float]) -> None:
        """Take heights and pose as read, m, and the exoskeleton's force on each finger (5,), N.

        The frame before was `dt_s` ago, s; 0 or less where that is not known.
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
        """Faults of the fingers that are stuck now."""
        if max(self.stuck_s) < STILL_S:
            return []
        return [
            Fault(FaultCode.FINGER_STILL, FINGERS[finger], value=since_s, limit=STILL_S)
            for finger, since_s in enumerate(self.stuck_s)
            if since_s >= STILL_S
        ]
