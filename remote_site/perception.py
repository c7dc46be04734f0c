"""Five fingers' identification in one step, and its result as the touch packet that travels."""

import math
from collections import deque
from collections.abc import Iterable

import numpy as np

from common.containment import Containment
from common.fingers import FINGERS
from common.hand_motion import HandMotion
from common.messages import (
    EVENT_MAX,
    MAX_EVENTS,
    TOUCH_BLOCK,
    TOUCH_FIELDS,
    TOUCH_HIGH,
    TOUCH_LOW,
    Event,
    EventKind,
    Touch,
)
from common.packets import Floats, LinkState
from common.recent_samples import RecentSamples
from common.serial_messages import DRIVE_FULL
from remote_site.finger_identification import FingerIdentification
from remote_site.finger_touch import FingerSample, FingerTouch
from remote_site.followed_hand import FollowedHand
from remote_site.heater_control import OFFSETS_K, STAGGER_K
from remote_site.material_table import MaterialTable
from remote_site.sensed import Sensed
from remote_site.shared_object import SharedObject
from remote_site.slow_telling import SlowTelling
from remote_site.solving_turns import Solver, SolvingTurns
from remote_site.surface_class import (
    GROOVE_DECAY_PER_S,
    GROOVE_RAD_S,
    TAP_DECAY_PER_S,
    TAP_SPEED_PER_M_S,
    SurfaceTable,
)
from remote_site.texture_sensor import texture_v
from remote_site.thermal_identification import ThermalKnowledge

TRUST_S = 2.0
"""In a session more goes on than the model of a touch has, and it grows: backs warm up, blocks give way, s."""
AT_ONCE = 40
"""Guesses about a touch solved with each reading of each finger: five fingers at once must not hold up the loop."""
FOREIGN_SHARE = 0.005
"""A session's table is made for what will be touched in it: prior probability of something else."""
HISTORY_S = 0.25
"""An event is repeated in every packet for this long: any later packet repairs a loss."""
FOUND_S = 0.1
"""A groove is found this long after it was crossed at most: by a stroke of 7 mm/s, 0.6 mm behind it."""
AGAIN_S = 1.0
"""After an exception nothing is identified for this long, s: making the estimators anew takes a tick's time."""
_THERMAL_UNKNOWN_SD_K = 50.0
_EFFUSIVITY_UNKNOWN_LN_SD = _STIFFNESS_UNKNOWN_LN_SD = 10.0
_FREE = (0.0,) * len(TOUCH_FIELDS)


class Perception:
    """Identification of all fingers in use. Pure: readings in, touches and events out.

    An exception in it is contained: nothing is touched then, and AGAIN_S later identification begins anew.
    """

    def __init__(
        self,
        fingers: Iterable[str],
        table: MaterialTable,
        surfaces: SurfaceTable,
        contain: Containment | None = None,
        period_s: float = 0.002,
    ):
        """Identify with the calibrated tables.

        Args:
            fingers: that take part.
            table: of materials.
            surfaces: of textures.
            contain: latches what identification raises, where it is given.
            period_s: of the ticks, s: one that is late postpones solutions, see `SolvingTurns`.
        """
        self._contain = contain or Containment()
        self._turns = SolvingTurns(period_s)
        self._broken_s = -math.inf
        self._numbers = [FINGERS.index(finger) for finger in fingers]
        self._knowledge, self._surfaces = ThermalKnowledge.of(table, TRUST_S, AT_ONCE, FOREIGN_SHARE), surfaces
        self._time_s, self._place_m = -math.inf, (0.0, 0.0)
        self.touches: dict[int, FingerTouch] = {}
        """Newest result of each finger in use, by finger number."""
        self._begin_anew()
        self._events: deque[Event] = deque(maxlen=MAX_EVENTS)
        self._event_count = 0

    def _begin_anew(self) -> None:
        """Identification that has felt nothing yet; events are numbered on, so that none is taken for an old one."""
        self._motion = HandMotion()
        self._identifications = {
            finger: FingerIdentification(
                finger, self._knowledge, self._surfaces, self._motion, OFFSETS_K[0] + stagger_k
            )
            for finger, stagger_k in zip(self._numbers, STAGGER_K, strict=False)
        }
        self._shared = SharedObject(self._knowledge)
        self._solvers: list[Solver] = [*(each.heat.thermal for each in self._identifications.values()), self._shared]
        self._hand = FollowedHand()
        self._places = RecentSamples(FOUND_S)
        self._telling = SlowTelling()

    def step(self, sensed: Sensed) -> list[Event]:
        """Take one tick's readings; return the events that happened in it."""
        if sensed.time_s < self._time_s:  # the clock was set back: what was timed by it is identified anew
            self._begin_anew()
            self._events.clear()
            self._broken_s = -math.inf
        self._time_s, self._place_m = sensed.time_s, (sensed.x_m, sensed.y_m)
        if sensed.time_s - self._broken_s >= AGAIN_S:
            with self._contain.step("identify"):
                return self._identify(sensed)
            self._begin_anew()
            self._broken_s = sensed.time_s
            self.touches.clear()
            self._events.clear()
        return []

    def _identify(self, sensed: Sensed) -> list[Event]:
        turn = self._turns.step(sensed.time_s, self._solvers)
        self._hand.step(sensed.hand)
        self._motion.step(sensed.time_s, sensed.x_m, sensed.y_m)
        self._places.take(sensed.time_s, sensed.x_m, sensed.y_m)
        happened: list[Event] = []
        for finger, identification in self._identifications.items():
            counts, plate = sensed.texture_counts[finger], sensed.plates[finger]
            touch = identification.step(
                FingerSample(
                    t_s=sensed.time_s,
                    force_n=sensed.force_n[finger],
                    x_m=sensed.x_m,
                    y_m=sensed.y_m,
                    z_m=sensed.z_m[finger],
                    texture_v=None if counts is None else texture_v(counts),
                    sensor_c=None if plate is None else plate.sensor_c,
                    ambient_c=None if plate is None else plate.ambient_c,
                    device_us=None if plate is None else plate.device_us,
                    heater_drive=0.0 if plate is None else plate.heater_permille / DRIVE_FULL,
                    sensor_fault=None if plate is None else plate.fault or None,
                    hurry=identification.heat.thermal is not turn,
                )
            )
            self.touches[finger] = touch
            for event in touch.events:
                self._event_count += 1
                kind = EventKind[event.kind.upper()]
                happened.append(
                    Event(
                        self._event_count,
                        kind,
                        finger,
                        round((sensed.time_s if event.time_s is None else event.time_s) * 1e9),
                        0 if kind is EventKind.MATERIAL else self._followed_ns(event.time_s),
                        _sendable(event.value),
                        event.name,
                    )
                )
        self._share(self._shared is not turn)
        self._telling.step(sensed.time_s, self._identifications)
        self._events.extend(happened)
        while self._events and sensed.time_s - self._events[0].time_ns * 1e-9 > HISTORY_S:
            self._events.popleft()
        return happened

    def _followed_ns(self, at_s: float | None) -> int:
        """When the operator's hand was where the fingers were at a time, now by default."""
        times_s, x_m, y_m = self._places.tracks
        if at_s is None:
            return self._hand.when_ns(x_m[-1], y_m[-1])
        return self._hand.when_ns(float(np.interp(at_s, times_s, x_m)), float(np.interp(at_s, times_s, y_m)))

    def _share(self, hurry: bool) -> None:
        """Give all fingers on one object one answer; they show it from the next tick on.

        Those on spots that they have warmed speak for themselves: their spots' temperatures are not the object's.
        """
        touching = {
            finger: identification.heat.thermal
            for finger, identification in self._identifications.items()
            if self.touches[finger].contact and not identification.heat.thermal.warmed
        }
        answer = self._shared.step(touching, hurry)
        for finger in touching:
            self._identifications[finger].heat.shared = answer
            self._identifications[finger].heat.thermal.alone = answer is None

    @property
    def postponed(self) -> int:
        """Ticks so far in which a solution was due and waited, since they were late."""
        return self._turns.postponed

    def packet(self, session: int, sequence: int, time_ns: int, state: LinkState) -> Touch:
        """The newest touches as a packet."""
        touches = [self.touches.get(finger) for finger in range(len(FINGERS))]
        rows = [_FREE if touch is None else _row(touch, *self._place_m) for touch in touches]
        names = tuple(["" if touch is None else touch.thermal.best or "" for touch in touches])
        # What an estimator says beyond the packet's ranges saturates there; a site never falls silent over it.
        block: Floats = np.array(rows, dtype=np.float32)
        np.minimum(np.maximum(block, TOUCH_LOW, out=block), TOUCH_HIGH, out=block)
        floats, events = TOUCH_BLOCK.to_bytes(block), tuple(self._events)
        return Touch(session, sequence, time_ns, state, floats, names, events, self._telling.told)


def nothing_touched(session: int, sequence: int, time_ns: int, state: LinkState) -> Touch:
    """A packet that says the site's state and nothing else."""
    block: Floats = np.array([_FREE] * len(FINGERS), dtype=np.float32)
    return Touch(session, sequence, time_ns, state, TOUCH_BLOCK.to_bytes(block), ("",) * len(FINGERS), ())


def _row(touch: FingerTouch, x_m: float, y_m: float) -> tuple[float, ...]:
    """One finger's line of the touch block, in the order of `TOUCH_FIELDS`, with the hand over (x, y)."""
    thermal = touch.thermal
    known = thermal.object_c is not None
    conducts = known and touch.conductivity_w_mk > 0.0
    return (
        float(touch.mode),
        float(touch.contact),
        touch.contact_force_n,
        x_m,
        y_m,
        touch.surface_z_m,
        # A finger that has left the object has no surface: none is rendered where nothing may be.
        touch.stiffness_n_m if touch.contact else 0.0,
        touch.stiffness_ln_sd if touch.contact else _STIFFNESS_UNKNOWN_LN_SD,
        touch.damping_n_s_m if touch.contact else 0.0,
        touch.slope_x if touch.contact else 0.0,
        touch.slope_y if touch.contact else 0.0,
        TAP_SPEED_PER_M_S,
        TAP_DECAY_PER_S,
        touch.k_stroke_v,
        touch.k_stroke_f,
        GROOVE_RAD_S,
        GROOVE_DECAY_PER_S,
        touch.conductivity_w_mk if known else 0.0,
        touch.density_kg_m3 if known else 0.0,
        touch.specific_heat_j_kgk if known else 0.0,
        _EFFUSIVITY_UNKNOWN_LN_SD if not conducts or thermal.effusivity_ln_sd is None else thermal.effusivity_ln_sd,
        thermal.object_c if thermal.object_c is not None else 0.0,
        thermal.object_c_sd or 0.0 if known else _THERMAL_UNKNOWN_SD_K,
        thermal.probability,
        float(thermal.status),
    )


def _sendable(value: float) -> float:
    """An event's value within what a packet may carry."""
    return min(max(float(value), 0.0), EVENT_MAX)
