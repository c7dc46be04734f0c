"""Vibration of one fingertip: tap, stroke and grooves as one motor speed (Kron & Schmidt 2003, Eq. 1 and 2).

The motor couples amplitude to speed, so everything here is a motor speed. What the hand does is known here
without delay; the network only says what the surface is like and which impulses occurred.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from common.limits import MOTOR_FLOOR_RPM, MOTOR_MAX_RPM
from common.messages import Event, EventKind, ExplorationMode
from operator_site.motor_drive import MOTOR, RPM_TO_RAD_S

TAP_S = 0.15
"""How long a tap is displayed."""
TAP_MIN_SPEED_M_S = 0.005
"""A contact slower than this is a resting of the finger, not a tap: it gets no guaranteed impulse."""
TAP_HOLD_S = 0.06
TAP_MIN_RAD_S = MOTOR_FLOOR_RPM * RPM_TO_RAD_S / (1.0 - math.exp(-TAP_HOLD_S / MOTOR.time_constant_s))
"""Least speed commanded during the first TAP_HOLD_S of a tap.

A usual tap of 40 mm/s on hard plastic asks for 160 rad/s, below what is felt at all. The motor needs 50 ms
to follow, so even the perception floor itself, shown for a few tens of ms, would not be reached: this
command makes the motor pass the floor by the end of the hold. Weaker than that, a tap may go unnoticed.
"""
GROOVE_DECAY_PER_S = 60.0
"""Decay of groove impulses where the surface model gives none."""
SHOWN_FROM = 0.35
SHOWN_UNTIL = 0.25
"""A wanted speed below the perception floor is shown as the floor from the first share of it, until the second.

Plain plastic stroked at 50 mm/s asks for half the floor and is felt; foam asks for a sixth of it and is not.
"""
REMEMBERED_EVENTS = 512

_MAX_RAD_S = MOTOR_MAX_RPM * RPM_TO_RAD_S


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

    def __init__(self) -> None:
        self._t_s = -math.inf
        self._tap_t_s = -math.inf
        self._tap_rad_s = 0.0
        self._tap_decay = 0.0
        self._tap_certain = False
        self._groove_rad_s = 0.0
        self._shown = False

    def step(
        self,
        t_s: float,
        mode: int,
        speed_m_s: float,
        force_n: float,
        *,
        surface: Surface,
        events: Iterable[Event] = (),
    ) -> float:
        """Motor speed at `t_s`, rpm: zero, or between the perception floor and the motor's largest.

        Args:
            t_s: time on any steady clock, s.
            mode: exploration mode (0 free, 1 tapping, 2 quiescent, 3 stroking).
            speed_m_s: stroke speed of the hand, either sign.
            force_n: normal force on the fingertip, N.
            surface: constants of Eq. 1 and 2.
            events: this finger's events not given before (see PlayedEvents).
        """
        dt_s = max(0.0, t_s - self._t_s)
        self._t_s = t_s
        if self._groove_rad_s:
            # A sum of equal exponentials decays as one: J(t) needs a single number.
            rate = surface.b_groove_per_s if surface.b_groove_per_s > 0.0 else GROOVE_DECAY_PER_S
            self._groove_rad_s *= math.exp(-rate * dt_s)
        for event in events:
            self._begin(event, surface)
        if mode == ExplorationMode.FREE:
            self._tap_t_s = -math.inf
            self._groove_rad_s = 0.0
            self._shown = False
            return 0.0
        wanted, least = self._tap(t_s)
        if mode == ExplorationMode.STROKING:
            wanted += surface.k_stroke_v * abs(speed_m_s) + surface.k_stroke_f * max(0.0, force_n)
            wanted += self._groove_rad_s
        else:
            self._groove_rad_s = 0.0
        return self._felt_rpm(max(wanted, least) / RPM_TO_RAD_S)

    def _begin(self, event: Event, surface: Surface) -> None:
        if event.kind is EventKind.TAP:
            self._tap_t_s = self._t_s
            self._tap_rad_s = surface.k_tap * max(0.0, event.value)
            self._tap_decay = surface.b_tap_per_s
            self._tap_certain = event.value >= TAP_MIN_SPEED_M_S
        elif event.kind is EventKind.GROOVE:
            self._groove_rad_s = min(_MAX_RAD_S, self._groove_rad_s + max(0.0, event.value))

    def _tap(self, t_s: float) -> tuple[float, float]:
        """Eq. 1 and the least speed that makes this tap felt, rad/s."""
        since_s = t_s - self._tap_t_s
        if since_s > TAP_S:
            return 0.0, 0.0
        certain = self._tap_certain and since_s <= TAP_HOLD_S
        return self._tap_rad_s * math.exp(-self._tap_decay * since_s), TAP_MIN_RAD_S if certain else 0.0

    def _felt_rpm(self, rpm: float) -> float:
        """Lift what is not felt to the floor or drop it to zero, with hysteresis."""
        self._shown = rpm >= MOTOR_FLOOR_RPM * (SHOWN_UNTIL if self._shown else SHOWN_FROM)
        return min(MOTOR_MAX_RPM, max(MOTOR_FLOOR_RPM, rpm)) if self._shown else 0.0
