"""What the exploring finger is doing: free, tapping, quiescent or stroking (Kron & Schmidt 2003, section 4.1).

The paper names the modes and what separates them (contact force, distance from the tap point,
stroke speed) and gives no values; those here carry hysteresis so that no mode chatters.
"""

import math

from common.messages import ExplorationMode

CONTACT_ON_N = 0.30
CONTACT_OFF_N = 0.15
"""Contact begins at the first and ends below the second, N."""
TAP_S = 0.15
"""How long a tap is a tap, s (T_t of Eq. 1)."""
STROKE_DISTANCE_M = 2e-3
STROKE_ON_M_S = 10e-3
STROKE_OFF_M_S = 7e-3
"""A stroke is this far from the tap point and faster than the second; slower than the third for REST_S ends it."""
REST_S = 0.050


class Exploration:
    """Mode machine of one finger.

    Attributes:
        mode: mode after the last step.
        contact: whether the finger touches; switched by force alone, without delay.
        began: whether the last step began a contact.
        ended: whether the last step ended one.
        contact_s: time at which the present (or last) contact began, s.
        approach_m_s: approach speed at that contact, m/s, >= 0 (v_n of Eq. 1).
    """

    __slots__ = (
        "_slow_since_s",
        "_tap_x_m",
        "_tap_y_m",
        "approach_m_s",
        "began",
        "contact",
        "contact_s",
        "ended",
        "mode",
    )

    def __init__(self) -> None:
        self.mode = ExplorationMode.FREE
        self.contact = False
        self.began = False
        self.ended = False
        self.contact_s = 0.0
        self.approach_m_s = 0.0
        self._tap_x_m = 0.0
        self._tap_y_m = 0.0
        self._slow_since_s: float | None = None

    def step(
        self, t_s: float, force_n: float, x_m: float, y_m: float, speed_m_s: float, *, approach_m_s: float = 0.0
    ) -> ExplorationMode:
        """Advance to `t_s` and return the mode.

        Args:
            t_s: time, s, not decreasing.
            force_n: contact force, N; not finite counts as none.
            x_m: hand position along the bench, m.
            y_m: hand position across it, m.
            speed_m_s: tangential speed, m/s, >= 0.
            approach_m_s: speed towards the object, m/s; kept where this step begins a contact.
        """
        self.began = self.ended = False
        if not self.contact:
            if force_n >= CONTACT_ON_N and force_n < math.inf:
                self.contact = self.began = True
                self.contact_s = t_s
                self.approach_m_s = max(approach_m_s, 0.0)
                self._tap_x_m, self._tap_y_m = x_m, y_m
                self._slow_since_s = None
                self.mode = ExplorationMode.TAPPING
            return self.mode
        if not CONTACT_OFF_N <= force_n < math.inf:
            self.contact = False
            self.ended = True
            self.mode = ExplorationMode.FREE
        elif t_s - self.contact_s < TAP_S:
            self.mode = ExplorationMode.TAPPING
        elif self.mode is ExplorationMode.STROKING:
            self._watch_for_rest(t_s, speed_m_s)
        else:
            away = math.hypot(x_m - self._tap_x_m, y_m - self._tap_y_m) > STROKE_DISTANCE_M
            stroking = away and speed_m_s > STROKE_ON_M_S
            self.mode = ExplorationMode.STROKING if stroking else ExplorationMode.QUIESCENT
            self._slow_since_s = None
        return self.mode

    def _watch_for_rest(self, t_s: float, speed_m_s: float) -> None:
        """End a stroke that has been slow for REST_S; a reversal is faster than that and goes on."""
        if speed_m_s >= STROKE_OFF_M_S:
            self._slow_since_s = None
        elif self._slow_since_s is None:
            self._slow_since_s = t_s
        elif t_s - self._slow_since_s >= REST_S:
            self.mode = ExplorationMode.QUIESCENT
            self._slow_since_s = None
