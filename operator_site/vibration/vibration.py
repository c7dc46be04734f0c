"""Vibration of one fingertip: tap, stroke and grooves as one motor speed (Kron & Schmidt 2003, Eq. 1 and 2).

The motor couples amplitude to speed, so everything here is a motor speed. What the hand does is known here
without delay; the network only says what the surface is like and which impulses occurred.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from common.config import VibrationScale
from common.limits import MOTOR_FLOOR_RPM
from common.wire.messages import Event, EventKind, ExplorationMode
from operator_site.vibration.grooves import Grooves
from operator_site.vibration.intensity_scale import IntensityScale
from operator_site.vibration.motor_drive import MOTOR, RPM_TO_RAD_S

TAP_S = 0.15
"""How long a tap is displayed."""
TAP_MIN_SPEED_M_S = 0.005
"""A contact slower than this is a resting of the finger, not a tap: it gets no guaranteed impulse."""
TAP_HOLD_S = 0.06
TAP_FELT_RPM = 1.2 * MOTOR_FLOOR_RPM
"""Least speed commanded during the first TAP_HOLD_S of a tap, by a difference in amplitude above what is felt at all.

A usual tap of 40 mm/s on hard plastic asks for 160 rad/s, below what is felt: as the law has it, it would go unnoticed.
"""
COMMAND_S = 0.006
"""From here to the motor: a tick, the module's rate of commands, and the line."""
AHEAD_S = 0.1
"""A contact that has not come by so long after the motor started for it will not."""
REMEMBERED_EVENTS = 512
_FREE, _STROKING = int(ExplorationMode.FREE), int(ExplorationMode.STROKING)


class PlayedEvents:
    """Lets each event through once, however many packets repeat it."""

    def __init__(self) -> None:
        self._seen: dict[int, None] = {}

    def new(self, events: Iterable[Event]) -> list[Event]:
        """Events never seen before, in their order; they count as seen from now on."""
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
    """What one touched surface does to the motor; zero everywhere means it says nothing."""

    k_tap: float = 0.0
    """Eq. 1, (rad/s)/(m/s)."""
    b_tap_per_s: float = 0.0
    k_stroke_v: float = 0.0
    """Eq. 2, (rad/s)/(m/s)."""
    k_stroke_f: float = 0.0
    """Eq. 2, (rad/s)/N."""
    b_groove_per_s: float = 0.0


class FingerVibration:
    """One finger's vibration: `step` says how fast its motor should turn."""

    def __init__(self, scale: VibrationScale = "speed") -> None:
        self._felt = IntensityScale(scale)
        self._grooves = Grooves()
        self._t_s = -math.inf
        self._tap_t_s = -math.inf
        self._tap_rad_s = 0.0
        self._tap_decay = 0.0
        self._tap_certain = False
        self._ahead_since_s: float | None = None
        self._at_rest = False
        """Nothing is felt, and nothing will be before an event, a stroke, or a contact that is known beforehand."""

    def step(
        self,
        t_s: float,
        mode: int,
        speed_m_s: float,
        force_n: float,
        *,
        surface: Surface,
        events: Sequence[Event] = (),
        contact_in_s: float = math.inf,
        approach_m_s: float = 0.0,
    ) -> float:
        """Motor speed at `t_s`, rpm: zero, or between the perception floor and the motor's largest.

        Args:
            t_s: time on any steady clock, s.
            mode: exploration mode (0 free, 1 tapping, 2 quiescent, 3 stroking).
            speed_m_s: stroke speed of the hand, either sign.
            force_n: normal force on the fingertip, N.
            surface: constants of Eq. 1 and 2.
            events: this finger's events not given before (see PlayedEvents).
            contact_in_s: when a free finger will meet this surface, s; infinite where nobody knows.
            approach_m_s: how fast it comes down then.
        """
        if self._at_rest and mode != _STROKING and not events and (mode != _FREE or contact_in_s == math.inf):
            return 0.0
        self._t_s = t_s
        self._at_rest = False
        self._grooves.step(t_s, surface.b_groove_per_s)
        for event in events:
            self._begin(event, surface)
        if mode == _FREE:
            self._tap_t_s = -math.inf
            self._grooves.end()
            self._felt.still()
            self._at_rest = contact_in_s == math.inf
            return self._ahead(contact_in_s, approach_m_s, surface)
        self._ahead_since_s = None
        wanted, least_rpm = self._tap()
        if mode == _STROKING:
            wanted += surface.k_stroke_v * abs(speed_m_s) + surface.k_stroke_f * max(0.0, force_n)
            wanted += self._grooves.rad_s
        else:
            self._grooves.end()
            self._at_rest = t_s - self._tap_t_s > TAP_S
        return max(self._felt.rpm(wanted / RPM_TO_RAD_S), least_rpm)

    def _begin(self, event: Event, surface: Surface) -> None:
        if event.kind is EventKind.TAP:
            self._tap_t_s = self._t_s
            self._tap_rad_s = surface.k_tap * max(0.0, event.value)
            self._tap_decay = surface.b_tap_per_s
            self._tap_certain = event.value >= TAP_MIN_SPEED_M_S
        elif event.kind is EventKind.GROOVE:
            self._grooves.cross(event.value, event.time_ns, surface.b_groove_per_s)

    def _tap(self) -> tuple[float, float]:
        """Eq. 1, rad/s, and the least speed that makes this tap felt, rpm."""
        since_s = self._t_s - self._tap_t_s
        if since_s > TAP_S:
            return 0.0, 0.0
        certain = self._tap_certain and since_s <= TAP_HOLD_S
        return self._tap_rad_s * math.exp(-self._tap_decay * since_s), TAP_FELT_RPM if certain else 0.0

    def _ahead(self, contact_in_s: float, approach_m_s: float, surface: Surface) -> float:
        """A tap that will come is begun so early that the motor turns as fast as it should on contact."""
        if surface.k_tap <= 0.0 or contact_in_s == math.inf:
            self._ahead_since_s = None
            self._felt.still()
            return 0.0
        rpm = max(self._felt.rpm(surface.k_tap * approach_m_s / RPM_TO_RAD_S), TAP_FELT_RPM)
        if contact_in_s > MOTOR.rise_s(rpm * RPM_TO_RAD_S) + COMMAND_S:
            self._ahead_since_s = None
        elif self._ahead_since_s is None:
            self._ahead_since_s = self._t_s
        if self._ahead_since_s is None or self._t_s - self._ahead_since_s > AHEAD_S:
            self._felt.still()
            return 0.0
        return rpm
