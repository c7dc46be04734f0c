"""Determine a finger's true exploration mode: the paper's rule on noise-free motion (Kron & Schmidt 2003, 4.1)."""

FREE, TAPPING, QUIESCENT, STROKING = range(4)
CONTACT_N = 0.30
RELEASE_N = 0.15
TAP_S = 0.15
STROKE_M = 0.002
STROKE_M_S = 0.010
REST_M_S = 0.007
REST_S = 0.100


class TrueMode:
    """Mode of one finger; `contact` is true from 0.30 N until the force falls below 0.15 N."""

    def __init__(self) -> None:
        self.mode = FREE
        self.contact = False
        self._since_s = 0.0
        self._slow_since_s: float | None = None
        self._tap_x_m = 0.0
        self._tap_y_m = 0.0

    def step(self, time_s: float, force_n: float, x_m: float, y_m: float, speed_m_s: float) -> int:
        """Return the mode at `time_s`: 0 free, 1 tapping, 2 quiescent, 3 stroking."""
        if not self.contact:
            if force_n < CONTACT_N:
                return self.mode
            self.contact, self.mode = True, TAPPING
            self._since_s, self._tap_x_m, self._tap_y_m = time_s, x_m, y_m
        elif force_n < RELEASE_N:
            self.contact, self.mode = False, FREE
        elif self.mode == TAPPING and time_s - self._since_s >= TAP_S - 1e-9:
            self.mode = QUIESCENT
        if self.mode == QUIESCENT:
            away = (x_m - self._tap_x_m) ** 2 + (y_m - self._tap_y_m) ** 2
            if speed_m_s > STROKE_M_S and away > STROKE_M**2:
                self.mode, self._slow_since_s = STROKING, None
        elif self.mode == STROKING:
            self._rest(time_s, speed_m_s)
        return self.mode

    def _rest(self, time_s: float, speed_m_s: float) -> None:
        if speed_m_s >= REST_M_S:
            self._slow_since_s = None
        elif self._slow_since_s is None:
            self._slow_since_s = time_s
        elif time_s - self._slow_since_s >= REST_S - 1e-9:
            self.mode = QUIESCENT
