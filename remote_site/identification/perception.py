"""Five fingers' identification in one step, and its result as the touch packet that travels."""

import math
from collections import deque
from collections.abc import Iterable

import numpy as np

from common.buses.serial_messages import DRIVE_FULL
from common.exploration.hand_motion import HandMotion
from common.exploration.sample_window import SampleWindow
from common.fingers import FINGERS
from common.runtime.containment import Containment
from common.wire.messages import EVENT_MAX, MAX_EVENTS, THERMAL_REASONS, Event, EventKind, Touch
from common.wire.packets import LinkState
from remote_site.devices.hand_path import HandPath
from remote_site.devices.sensor_frame import SensorFrame
from remote_site.devices.texture_sensor import texture_v
from remote_site.finger_sample import FingerSample
from remote_site.identification.finger_identification import FingerIdentification
from remote_site.identification.finger_touch import FingerTouch, TouchEvent
from remote_site.identification.touch_block import touch_block
from remote_site.identification.touch_summary import TouchSummaries
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.shared_object import SharedObject
from remote_site.thermal.solving_turns import Solver, SolvingTurns
from remote_site.thermal.thermal_identification import ThermalKnowledge

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


class Perception:
    """Identification of all fingers in use. Pure: readings in, touches and events out.

    A tick takes a `step`, and `work` when nothing else waits for it.

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
            finger: FingerIdentification(finger, self._knowledge, self._surfaces, self._motion)
            for finger in self._numbers
        }
        self._shared = SharedObject(self._knowledge)
        self._solvers: list[Solver] = [*(each.thermal for each in self._identifications.values()), self._shared]
        self._hand = HandPath()
        self._places = SampleWindow(FOUND_S)
        self._summaries = TouchSummaries()

    def step(self, sensed: SensorFrame) -> list[Event]:
        """Take one tick's readings; return the events that happened in it."""
        if sensed.time_s < self._time_s:  # the clock was set back: what was timed by it is identified anew
            self._begin_anew()
            self._events.clear()
            self._broken_s = -math.inf
        self._time_s, self._place_m = sensed.time_s, (sensed.x_m, sensed.y_m)
        if sensed.time_s - self._broken_s >= AGAIN_S:
            with self._contain.step("identify"):
                return self._identify(sensed)
            self._give_up()
        return []

    def work(self) -> None:
        """Do one piece of slow work that is due, once this tick's packet is sent; the next tick shows its result."""
        if self._time_s - self._broken_s < AGAIN_S:
            return
        with self._contain.step("solve"):
            if (solver := self._turns.step(self._time_s, self._solvers)) is not None:
                solver.work()
            return
        self._give_up()

    def _give_up(self) -> None:
        """Touch nothing, and identify anew in AGAIN_S."""
        self._begin_anew()
        self._broken_s = self._time_s
        self.touches.clear()
        self._events.clear()

    def _identify(self, sensed: SensorFrame) -> list[Event]:
        time_s, x_m, y_m = sensed.time_s, sensed.x_m, sensed.y_m
        self._hand.step(sensed.hand)
        self._motion.step(time_s, x_m, y_m)
        self._places.take(time_s, x_m, y_m)
        happened: list[Event] = []
        for finger, identification in self._identifications.items():
            touch = self.touches[finger] = identification.step(_sample(sensed, finger))
            if touch.events:
                happened += self._happened(finger, touch.events)
        self._share()
        self._summaries.step(time_s, self._identifications)
        self._events.extend(happened)
        while self._events and time_s - self._events[0].time_ns * 1e-9 > HISTORY_S:
            self._events.popleft()
        return happened

    def _happened(self, finger: int, events: Iterable[TouchEvent]) -> list[Event]:
        """What a finger's events are in a packet, numbered."""
        happened = []
        for event in events:
            self._event_count += 1
            kind = EventKind[event.kind.upper()]
            happened.append(
                Event(
                    self._event_count,
                    kind,
                    finger,
                    round((self._time_s if event.time_s is None else event.time_s) * 1e9),
                    0 if kind is EventKind.MATERIAL else self._followed_ns(event.time_s),
                    _sendable(event.value),
                    event.name,
                )
            )
        return happened

    def _followed_ns(self, at_s: float | None) -> int:
        """When the operator's hand was where the fingers were at a time, now by default."""
        if at_s is None:
            return self._hand.when_ns(*self._place_m)
        times_s, x_m, y_m = self._places.tracks
        return self._hand.when_ns(float(np.interp(at_s, times_s, x_m)), float(np.interp(at_s, times_s, y_m)))

    def _share(self) -> None:
        """Give all fingers on one object one answer, which their next steps return.

        Those on spots that they have warmed speak for themselves: their spots' temperatures are not the object's.
        """
        touching = {
            finger: identification.thermal
            for finger, identification in self._identifications.items()
            if identification.contact and not identification.thermal.warmed
        }
        answer = self._shared.look(touching)
        for finger in touching:
            self._identifications[finger].share(answer)

    @property
    def postponed(self) -> int:
        """Ticks so far in which a solution was due and waited, since they were late."""
        return self._turns.postponed

    def packet(self, session: int, sequence: int, time_ns: int, state: LinkState) -> Touch:
        """The newest touches as a packet."""
        names = [""] * len(FINGERS)
        for finger, touch in self.touches.items():
            names[finger] = touch.thermal.best or ""
        floats, events = touch_block(self.touches, *self._place_m), tuple(self._events)
        return Touch(session, sequence, time_ns, state, floats, tuple(names), events, self._summaries.summaries)


def _sample(sensed: SensorFrame, finger: int) -> FingerSample:
    """One finger's part of what was sensed."""
    counts, plate = sensed.texture_counts[finger], sensed.plates[finger]
    signal_v = None if counts is None else texture_v(counts)
    force_n, z_m = sensed.force_n[finger], sensed.z_m[finger]
    sample = FingerSample(sensed.time_s, force_n, sensed.x_m, sensed.y_m, z_m, signal_v)
    if plate is not None:
        sample.sensor_c, sample.ambient_c, sample.device_us = plate.sensor_c, plate.ambient_c, plate.device_us
        sample.sensor_fault = THERMAL_REASONS[plate.fault]
        sample.heater_drive = plate.heater_permille / DRIVE_FULL
    return sample


def nothing_touched(session: int, sequence: int, time_ns: int, state: LinkState) -> Touch:
    """A packet that says the site's state and nothing else."""
    return Touch(session, sequence, time_ns, state, touch_block({}, 0.0, 0.0), ("",) * len(FINGERS), ())


def _sendable(value: float) -> float:
    """An event's value within what a packet may carry."""
    return min(max(float(value), 0.0), EVENT_MAX)
