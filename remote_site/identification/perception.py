"""Identifies with all fingers in one step, and packs the result as a touch packet."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from common.exploration.hand_motion import HandMotion
from common.fingers import FINGERS
from common.runtime.containment import Containment
from common.wire.messages import NO_TOUCH, TOUCH_BLOCK, TOUCH_HIGH, TOUCH_LOW, Event, Touch, TouchRow, pack_rows
from common.wire.packets import BadPacket, Floats, LinkState
from remote_site.devices.sensor_frame import SensorFrame
from remote_site.identification.finger_identification import FingerIdentification
from remote_site.identification.touch_events import TouchEvents
from remote_site.identification.touch_summary import TouchSummaries
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.shared_object import SharedObject
from remote_site.thermal.solving_turns import Solver, SolvingTurns
from remote_site.thermal.thermal_identification import ThermalKnowledge

AT_ONCE = 40
"""Number of hypotheses of a touch that are solved with each reading of each finger; five fingers share a tick."""
FOREIGN_SHARE = 0.005
"""Prior probability of a material outside of the session's table; a table is made for the session's objects."""
_NOTHING = (NO_TOUCH,) * len(FINGERS)
AGAIN_S = 1.0
"""Time without identification after an exception, s; creating the estimators takes a tick's time."""


class Perception:
    """Identification of all fingers in use. Pure: readings in, touches and events out.

    A tick takes a `step`, and `work` when nothing else waits for it. An exception is contained: nothing is touched
    then, and identification restarts AGAIN_S later.

    Attributes:
        touches: identification of each finger in use, by finger number; empty after an exception.
    """

    def __init__(
        self,
        fingers: Iterable[str],
        table: MaterialTable,
        surfaces: SurfaceTable,
        contain: Containment | None = None,
        period_s: float = 0.002,
    ):
        """Identify with the calibrated materials and surfaces; `contain` latches exceptions, if given.

        A tick later than `period_s`, s, postpones solutions, see `SolvingTurns`.
        """
        self._contain = contain or Containment()
        self._turns = SolvingTurns(period_s)
        self._broken_s = -math.inf
        self._numbers = [FINGERS.index(finger) for finger in fingers]
        self._knowledge, self._surfaces = ThermalKnowledge.of(table, AT_ONCE, FOREIGN_SHARE), surfaces
        self._time_s = -math.inf
        self.touches: dict[int, FingerIdentification] = {}
        self._events = TouchEvents()
        self._restart()

    def _restart(self) -> None:
        """Begin again without any touch."""
        self._events.forget()
        self._motion = HandMotion()
        self._fingers = {
            finger: FingerIdentification(finger, self._knowledge, self._surfaces, self._motion, self._events)
            for finger in self._numbers
        }
        self._shared = SharedObject(self._knowledge)
        self._solvers: list[Solver] = [*(finger.thermal.own for finger in self._fingers.values()), self._shared]
        self._summaries = TouchSummaries()

    def step(self, sensed: SensorFrame) -> list[Event]:
        """Take one tick's readings; return its events."""
        if sensed.time_s < self._time_s:  # the clock was set back, and old times are of no use
            self._restart()
            self._broken_s = -math.inf
        self._time_s = sensed.time_s
        if sensed.time_s - self._broken_s >= AGAIN_S:
            with self._contain.step("identify"):
                self._identify(sensed)
                return self._events.new
            self._give_up()
        return []

    def work(self) -> None:
        """Do one due piece of slow work, after this tick's packet was sent; the next tick shows its result."""
        if self._time_s - self._broken_s < AGAIN_S:
            return
        with self._contain.step("solve"):
            if (solver := self._turns.step(self._time_s, self._solvers)) is not None:
                solver.work()
            return
        self._give_up()

    def _give_up(self) -> None:
        """Touch nothing, and identify again in AGAIN_S."""
        self._restart()
        self._broken_s = self._time_s
        self.touches.clear()

    def _identify(self, sensed: SensorFrame) -> None:
        self._events.step(sensed)
        self._motion.step(sensed.time_s, sensed.x_m, sensed.y_m)
        for number, finger in self._fingers.items():
            finger.step(sensed)
            self.touches[number] = finger
        self._share()
        self._summaries.step(sensed.time_s, self._fingers)

    def _share(self) -> None:
        """Give all fingers on one object the same answer, which their next steps return.

        Fingers on spots that they have warmed answer for themselves, because these spots have their own temperatures.
        """
        touching = {
            number: finger.thermal
            for number, finger in self._fingers.items()
            if finger.contact and not finger.thermal.own.warmed
        }
        answer = self._shared.look({number: thermal.own for number, thermal in touching.items()})
        for thermal in touching.values():
            thermal.share(answer)

    @property
    def postponed(self) -> int:
        """Number of late ticks in which a due solution waited."""
        return self._turns.postponed

    def packet(self, session: int, sequence: int, time_ns: int, state: LinkState) -> Touch:
        """Return the newest touches as a packet."""
        rows, names = [NO_TOUCH] * len(FINGERS), [""] * len(FINGERS)
        for number, finger in self.touches.items():
            rows[number], names[number] = finger.row, finger.thermal.answer.best or ""
        events, summaries = tuple(self._events.recent), self._summaries.summaries
        return Touch(session, sequence, time_ns, state, touch_block(rows), tuple(names), events, summaries)


def nothing_touched(session: int, sequence: int, time_ns: int, state: LinkState) -> Touch:
    """Return a packet with the site's state and nothing else."""
    return Touch(session, sequence, time_ns, state, touch_block(_NOTHING), ("",) * len(FINGERS), ())


def touch_block(rows: Sequence[TouchRow]) -> bytes:
    """Return the bytes of a touch block; a value beyond its range saturates, so that the site keeps sending."""
    try:
        return TOUCH_BLOCK.check(pack_rows(rows))
    except (BadPacket, OverflowError):
        block: Floats = np.array(rows, dtype=np.float32)
        return TOUCH_BLOCK.to_bytes(np.minimum(np.maximum(block, TOUCH_LOW), TOUCH_HIGH))
