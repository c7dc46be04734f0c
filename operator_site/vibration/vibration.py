"""Computes one fingertip's vibration from tap, stroke and grooves (Kron & Schmidt 2003, Eq. 1 and 2).

The motor couples amplitude to speed, so all results are motor speeds. The motion of the hand is known locally without
delay. The network supplies only the constants of the surface and the impulses.

A finger feels the motor's acceleration, which grows with the square of its speed. A law that is linear in speed is
therefore quadratic in intensity. The scale `intensity` makes the law linear in intensity.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from common.config.site_models import VibrationScale
from common.exploration.exploration_mode import REST_S, STROKE_OFF_M_S
from common.limits import MOTOR_FLOOR_RPM, MOTOR_MAX_RPM
from common.wire.messages import Event, EventKind, ExplorationMode, TouchRow
from operator_site.vibration.grooves import Grooves
from operator_site.vibration.motor_drive import MOTOR, RPM_TO_RAD_S

TAP_S = 0.15
"""Duration of a displayed tap, s."""
TAP_MIN_SPEED_M_S = 0.005
"""Smallest contact speed of a tap, m/s; a slower contact gets no guaranteed impulse."""
TAP_HOLD_S = 0.06
"""Duration of the guaranteed impulse of a tap, s."""
TAP_FELT_RPM = 1.2 * MOTOR_FLOOR_RPM
"""Smallest speed during the first TAP_HOLD_S of a tap, rpm: one amplitude JND above the perception floor.

A usual tap of 40 mm/s on hard plastic needs 160 rad/s by the law, which is below the floor and would go unnoticed.
"""
COMMAND_S = 0.006
"""Delay from this step to the motor, s: a tick, the module's command interval, and the line."""
AHEAD_S = 0.1
"""Longest wait for an expected contact after the motor has started for it, s."""
REMEMBERED_EVENTS = 512
"""Maximum number of remembered events."""
SHOWN: dict[VibrationScale, tuple[float, float]] = {"speed": (0.35, 0.25), "intensity": (1.0, 0.8)}
"""Hysteresis of raising a lower speed to the perception floor: it begins at the first share of it, ends at the second.

On the paper's scale, plain plastic stroked at 50 mm/s needs half the floor and is displayed. Foam needs a sixth of it
and is not displayed. On the intensity scale, speeds below the floor are imperceptible.
"""
_FREE, _STROKING = int(ExplorationMode.FREE), int(ExplorationMode.STROKING)


class PlayedEvents:
    """Passes each event once, although packets repeat it."""

    def __init__(self) -> None:
        self._seen: dict[int, None] = {}

    def new(self, events: Iterable[Event]) -> list[Event]:
        """Return the events not seen before, in their order, and remember them."""
        fresh = []
        for event in events:
            if event.ident not in self._seen:
                self._seen[event.ident] = None
                fresh.append(event)
        while len(self._seen) > REMEMBERED_EVENTS:
            del self._seen[next(iter(self._seen))]
        return fresh


@dataclass(frozen=True, slots=True)
class Surface:
    """Constants of a touched surface for the motor's speed; all zero if unknown."""

    k_tap: float = 0.0
    """Eq. 1, (rad/s)/(m/s)."""
    b_tap_per_s: float = 0.0
    k_stroke_v: float = 0.0
    """Eq. 2, (rad/s)/(m/s)."""
    k_stroke_f: float = 0.0
    """Eq. 2, (rad/s)/N."""
    b_groove_per_s: float = 0.0


class FingerVibration:
    """Vibration of one finger; `step` returns the speed of its motor."""

    def __init__(self, scale: VibrationScale = "speed") -> None:
        self._scale = IntensityScale(scale)
        self._grooves = Grooves()
        self._t_s = -math.inf
        self._tap_t_s = -math.inf
        self._tap_rad_s = 0.0
        self._tap_decay = 0.0
        self._tap_certain = self._tap_late = False
        self._ahead_since_s: float | None = None
        self._moved_s = -math.inf
        """Last time at which the hand moved as in a stroke, s."""
        self._at_rest = False
        """Whether nothing is displayed until an event, a stroke, or a predicted contact."""

    def step(
        self,
        t_s: float,
        mode: float,
        speed_m_s: float,
        force_n: float,
        *,
        surface: Surface | TouchRow,
        events: Sequence[Event] = (),
        contact_in_s: float = math.inf,
        approach_m_s: float = 0.0,
    ) -> float:
        """Return the motor speed at `t_s`, rpm: 0, or between the perception floor and the motor's largest speed.

        Args:
            t_s: time on any steady clock, s.
            mode: exploration mode (0 free, 1 tapping, 2 quiescent, 3 stroking).
            speed_m_s: stroke speed of the hand, either sign.
            force_n: normal force on the fingertip, N.
            surface: constants of Eq. 1 and 2.
            events: new events of this finger (see PlayedEvents).
            contact_in_s: time until a free finger meets this surface, s; infinite if unknown.
            approach_m_s: speed of the finger towards the surface, m/s.
        """
        if self._at_rest and mode != _STROKING and not events and (mode != _FREE or contact_in_s == math.inf):
            return 0.0
        self._t_s = t_s
        self._at_rest = False
        self._grooves.step(t_s, surface.b_groove_per_s)
        for event in events:
            self._begin(event, surface, late=mode == _FREE)
        if mode == _FREE:
            self._grooves.end()
            if self._tap_late and t_s - self._tap_t_s <= TAP_HOLD_S:
                wanted, least_rpm = self._tap()
                return max(self._scale.rpm(wanted / RPM_TO_RAD_S), least_rpm)
            self._tap_t_s = -math.inf
            self._scale.still()
            self._at_rest = contact_in_s == math.inf
            return self._ahead(contact_in_s, approach_m_s, surface)
        self._ahead_since_s = None
        wanted, least_rpm = self._tap()
        if mode == _STROKING:
            if abs(speed_m_s) >= STROKE_OFF_M_S:
                self._moved_s = t_s
            # The mode comes late over the network. A hand that rests by the same rule ends the stroke at once.
            if t_s - self._moved_s <= REST_S:
                wanted += surface.k_stroke_v * abs(speed_m_s) + surface.k_stroke_f * max(0.0, force_n)
            wanted += self._grooves.rad_s
        else:
            self._grooves.end()
            self._at_rest = t_s - self._tap_t_s > TAP_S
        return max(self._scale.rpm(wanted / RPM_TO_RAD_S), least_rpm)

    def _begin(self, event: Event, surface: Surface | TouchRow, late: bool) -> None:
        """Begin an event; a late one arrives after the finger has left."""
        if event.kind is EventKind.TAP:
            self._tap_t_s = self._t_s
            self._tap_rad_s = surface.k_tap * max(0.0, event.value)
            self._tap_decay = surface.b_tap_per_s
            self._tap_certain = event.value >= TAP_MIN_SPEED_M_S
            self._tap_late = late
        elif event.kind is EventKind.GROOVE:
            self._grooves.cross(event.value, event.time_ns, surface.b_groove_per_s)

    def _tap(self) -> tuple[float, float]:
        """Return the speed by Eq. 1, rad/s, and the smallest speed at which this tap is felt, rpm."""
        since_s = self._t_s - self._tap_t_s
        if since_s > TAP_S:
            return 0.0, 0.0
        certain = self._tap_certain and since_s <= TAP_HOLD_S
        return self._tap_rad_s * math.exp(-self._tap_decay * since_s), TAP_FELT_RPM if certain else 0.0

    def _ahead(self, contact_in_s: float, approach_m_s: float, surface: Surface | TouchRow) -> float:
        """Return the speed for an expected tap, rpm, so early that the motor has its speed on contact."""
        if surface.k_tap <= 0.0 or contact_in_s == math.inf:
            self._ahead_since_s = None
            self._scale.still()
            return 0.0
        rpm = max(self._scale.rpm(surface.k_tap * approach_m_s / RPM_TO_RAD_S), TAP_FELT_RPM)
        if contact_in_s > MOTOR.rise_s(rpm * RPM_TO_RAD_S) + COMMAND_S:
            self._ahead_since_s = None
        elif self._ahead_since_s is None:
            self._ahead_since_s = self._t_s
        if self._ahead_since_s is None or self._t_s - self._ahead_since_s > AHEAD_S:
            self._scale.still()
            return 0.0
        return rpm


class IntensityScale:
    """Scales the speed of Eq. 1 and 2 to that of a motor, with hysteresis at the perception floor."""

    def __init__(self, scale: VibrationScale = "speed") -> None:
        self._scale: VibrationScale = scale
        self._from, self._until = SHOWN[scale]
        self._shown = False

    def still(self) -> None:
        """Reset the hysteresis, because nothing is displayed."""
        self._shown = False

    def rpm(self, wanted_rpm: float) -> float:
        """Return the motor speed, rpm: 0, or between the perception floor and the motor's largest speed."""
        if self._scale == "intensity":
            wanted_rpm = MOTOR_MAX_RPM * math.sqrt(max(0.0, wanted_rpm) / MOTOR_MAX_RPM)
        self._shown = wanted_rpm >= MOTOR_FLOOR_RPM * (self._until if self._shown else self._from)
        return min(MOTOR_MAX_RPM, max(MOTOR_FLOOR_RPM, wanted_rpm)) if self._shown else 0.0
