"""Detects the exploration mode: free, tapping, quiescent or stroking (Kron & Schmidt 2003, section 4.1).

The paper names the modes and their criteria (contact force, distance from the tap point, stroke speed) without values.
The values are the constants below. The state machine:

    from                 to          when
    any                  FREE        the contact ends
    FREE                 TAPPING     a contact begins; it lasts TAP_S
    TAPPING, QUIESCENT   STROKING    faster than STROKE_ON_M_S, farther than STROKE_DISTANCE_M from the tap point, and
                                     farther than PLACE_M from the middle of the recent positions
    TAPPING              QUIESCENT   TAP_S are over and it does not stroke
    STROKING             QUIESCENT   slower than STROKE_OFF_M_S for REST_S, or within PLACE_M for a quarter of a second

QUIESCENT lasts at least DWELL_S while there is contact. STROKING needs no dwell time, because its end takes time.
Reasons and limits: docs/decisions/0017-modes.md.
"""

import math

from common.exploration.approach_speed import ApproachSpeed
from common.exploration.contact_detector import FREE_N, TAP_S, ContactDetector
from common.exploration.force_offset import ForceOffset
from common.exploration.hand_motion import WINDOW_S, HandMotion
from common.exploration.position_spread import SPREAD_WINDOW_S
from common.wire.messages import ExplorationMode

STROKE_DISTANCE_M = 2e-3
STROKE_ON_M_S = 10e-3
STROKE_OFF_M_S = 7e-3
REST_S = 0.100
"""Time below STROKE_OFF_M_S after which a stroke ends, s; a turning stroke is slow for a shorter time."""
DWELL_S = 0.050
PLACE_M = 0.5 * STROKE_OFF_M_S * SPREAD_WINDOW_S
"""Maximum distance of a resting finger from the middle of the positions in the last SPREAD_WINDOW_S, m. The slowest
stroke gets this far from it."""


class ModeDetector:
    """State machine for the mode of one finger.

    Attributes:
        mode: mode after the last step.
        approach_m_s: approach speed at the present or last contact, m/s, >= 0 (v_n of Eq. 1), measured before the force
            rose.
        contact: whether the finger touches.
        began: whether the last step began a contact; a bounce within a tap begins none.
        ended: whether the last step ended a contact.
    """

    def __init__(self, hand: HandMotion) -> None:
        """Detect the mode of a finger of `hand`; step the hand first."""
        self.mode = ExplorationMode.FREE
        self.approach_m_s = 0.0
        self.contact = self.began = self.ended = False
        self._contact = ContactDetector()
        self._approach = ApproachSpeed()
        self._offset = ForceOffset()
        self._hand = hand
        self._fall_m_s = 0.0
        self._tap_m = (0.0, 0.0)
        self._mode_s = 0.0
        self._slow_s = 0.0
        """Time since which the finger is slow, s."""
        self._since_s = -math.inf
        """Earlier positions of the hand are ignored, s."""

    @property
    def speed_m_s(self) -> float:
        """Tangential speed, m/s, >= 0."""
        return self._hand.speed_m_s

    @property
    def offset_n(self) -> float:
        """Offset of the finger's force sensor, N, which does not count as a force."""
        return self._offset.offset_n

    def step(self, t_s: float, force_n: float, z_m: float) -> ExplorationMode:
        """Advance to `t_s` and return the mode.

        Args:
            t_s: time, s, not decreasing.
            force_n: measured contact force, N; a value that is not finite counts as 0.
            z_m: height of the fingertip, m.
        """
        contact, hand = self._contact, self._hand
        was_free = contact.force_n < FREE_N
        self._offset.step(t_s, force_n, hand.x_m, hand.y_m, z_m)
        contact.step(t_s, force_n - self._offset.offset_n)
        if was_free and contact.force_n >= FREE_N:
            self._fall_m_s = self._approach.speed_m_s  # of the last tick without a force
        self._approach.step(t_s, z_m)
        self.contact, self.began, self.ended = contact.touching, contact.began, contact.ended
        if contact.began:
            self.approach_m_s = max(self._fall_m_s, 0.0)
            self._tap_m = (hand.x_m, hand.y_m)
        if hand.speed_m_s >= STROKE_OFF_M_S:
            self._slow_s = t_s - 0.5 * WINDOW_S  # the speed is that of half a window ago
        if t_s < self._since_s:
            self._since_s = -math.inf
        mode = self._next(t_s) if contact.touching else ExplorationMode.FREE
        if mode is not self.mode:
            self.mode, self._mode_s = mode, t_s
        return mode

    def _next(self, t_s: float) -> ExplorationMode:
        """Return the next mode of a touching finger, which may be the present one."""
        if t_s - self._contact.began_s < TAP_S:
            return ExplorationMode.TAPPING
        if self.mode is ExplorationMode.STROKING:
            return ExplorationMode.QUIESCENT if self._rests(t_s) else self.mode
        if self.mode is ExplorationMode.QUIESCENT and t_s - self._mode_s < DWELL_S:
            return self.mode
        return ExplorationMode.STROKING if self._strokes() else ExplorationMode.QUIESCENT

    def _strokes(self) -> bool:
        hand = self._hand
        return (
            hand.speed_m_s > STROKE_ON_M_S
            and math.hypot(hand.x_m - self._tap_m[0], hand.y_m - self._tap_m[1]) > STROKE_DISTANCE_M
            and hand.spread.away_m(hand.x_m, hand.y_m, self._since_s) > PLACE_M
        )

    def _rests(self, t_s: float) -> bool:
        if t_s - self._slow_s >= REST_S:
            self._since_s = self._slow_s
            return True
        return t_s - self._mode_s > SPREAD_WINDOW_S and self._hand.spread.reach_m(self._since_s) < PLACE_M
