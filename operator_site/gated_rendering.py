"""Renders all fingers and passes the gate: from a tick's input to the outputs that may reach the devices.

The input and the touch packet that it names are recorded, and replay renders the same outputs from them.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace

from common.config.site_models import RenderingConfig
from common.faults.fault import Fault, contained
from common.fingers import FINGERS
from common.limits import GAP_S, PLATE_PROFILES
from common.runtime.containment import Containment
from common.wire.messages import NO_TOUCH, Touch
from operator_site.coupling.coupling import DIRECT, Coupling
from operator_site.fingertips import Fingertips
from operator_site.recorded_rows import RenderingInput
from operator_site.safety.gated_output import GatedOutput, Outputs, neutral
from operator_site.safety.operator_gate import OperatorGate
from operator_site.safety.sampled_wall import SampledWall
from operator_site.thermal.tissue import Body

_NO_TOUCHES = (NO_TOUCH,) * len(FINGERS)
"""Touch rows without contact, rendered while there is no fresh touch."""
_NO_INPUT_S = 1e9
"""Age of an input that never came, s."""
SETTLES_S = 0.25
"""Time constant of the mean period, s."""
SLACK = 1.5
"""Largest ratio of mean to nominal period that leaves the wall unchanged."""
LONGEST_S = 0.1
"""Longest pause that enters the mean, s; a longer one releases all forces."""
WINDOW_S = 0.020
"""Window of the mean speed, s; one pose step of 0.02 mm over it is 1 mm/s."""
LEAST_S = 0.009
"""Shortest part of the window that gives a speed, s."""
SILENCE_S = 0.025
"""Gap after which poses count as delayed, s; they come in a burst with new times, which would look like a leap."""
SETTLE_S = 0.010
"""Time after such a gap for which poses are ignored, s; the former speed holds until new poses give another."""


class StrokeSpeed:
    """Mean speed of the operator's hand in the bench plane over the last WINDOW_S, from its quantised pose."""

    def __init__(self) -> None:
        self._track: deque[tuple[float, float, float]] = deque()
        self._t_s = -math.inf
        self._trusted_s = -math.inf
        self._speed_m_s = 0.0

    def step(self, t_s: float, x_m: float, y_m: float) -> float:
        """Take the pose at `t_s`; return the speed, m/s, >= 0, which restarts at 0 after GAP_S or a clock set back."""
        since_s = t_s - self._t_s
        if since_s == 0.0:
            return self._speed_m_s
        self._t_s = t_s
        if not 0.0 < since_s <= GAP_S:
            self._track.clear()
            self._trusted_s, self._speed_m_s = -math.inf, 0.0
        elif since_s > SILENCE_S:
            self._track.clear()
            self._trusted_s = t_s + SETTLE_S
        if t_s < self._trusted_s:
            return self._speed_m_s
        track = self._track
        track.append((t_s, x_m, y_m))
        while t_s - track[0][0] > WINDOW_S + 1e-4:
            track.popleft()
        old_s, old_x, old_y = track[0]
        if t_s - old_s >= LEAST_S:
            self._speed_m_s = math.hypot(x_m - old_x, y_m - old_y) / (t_s - old_s)
        return self._speed_m_s


class LoopStiffness:
    """Limits the displayed stiffness by the loop's measured period, because a slow loop holds each force longer.

    The bound of the sampled wall contains half of the period, the mean age of a held force. The relevant period is
    therefore the mean over time instead of the mean over ticks. One pause in a second is imperceptible. A loop or
    device that works for only 10 ms in every 40 ms displays a softer wall until it recovers.

    Attributes:
        wall: bound of the walls that the loop can display passively at present.
    """

    def __init__(self, wall: SampledWall) -> None:
        self._kept = self.wall = wall
        self._held_s = wall.period_s
        self._t_s = self._height_s = math.nan

    def step(self, t_s: float, height_s: float) -> None:
        """Take one tick.

        Args:
            t_s: time, s.
            height_s: time of the measured heights that it answers, s; a repeated time is ignored.
        """
        if height_s == self._height_s:
            return
        passed_s = t_s - self._t_s
        self._t_s, self._height_s = t_s, height_s
        if not 0.0 < passed_s <= LONGEST_S:
            return
        self._held_s += min(1.0, passed_s / SETTLES_S) * (passed_s - self._held_s)
        if self._held_s > SLACK * self._kept.period_s:
            self.wall = replace(self._kept, period_s=self._held_s)
        else:
            self.wall = self._kept


class GatedRendering:
    """Renders touch for all fingers, through the gate. Pure: one tick's input in, gated output out.

    An exception of the renderer latches a fault, and requests are neutral until it is cleared. An exception of the
    gate itself is not caught here.

    Attributes:
        fingertips: the renderer after the last step.
        pushed_n: force on each finger of the last step, N.
    """

    def __init__(self, config: RenderingConfig, period_s: float, gap_s: float, contain: Containment | None = None):
        """Begin with a new renderer.

        Args:
            config: plate profile, damping and delay of the exoskeleton, temperatures of body and air.
            period_s: nominal period of the loop, s.
            gap_s: longest gap between accepted touch packets, s; after a longer one nothing is touched.
            contain: counts and logs exceptions of the renderer; a new one by default.
        """
        self._contain = contain or Containment()
        self._config = config
        self._loop = LoopStiffness(SampledWall(config.exoskeleton_damping_n_s_m, period_s, config.exoskeleton_delay_s))
        self._gate = OperatorGate(PLATE_PROFILES[config.profile], self.wall)
        self._gap_ns = round(gap_s * 1e9)
        self._session = 0
        self._time_s = -math.inf
        self._touch: Touch | None = None
        self._rows = _NO_TOUCHES
        self.pushed_n = [0.0] * len(FINGERS)
        self._restart()

    def _restart(self) -> None:
        """Create a new renderer."""
        config = self._config
        self.fingertips = Fingertips(
            self.wall,
            PLATE_PROFILES[config.profile],
            body=Body(deep_c=config.deep_c, arterial_c=config.deep_c + 1.0, air_c=config.air_c),
            vibration=config.vibration,
        )
        self._speed = StrokeSpeed()
        self._broken = ""
        """Name of the exception that the renderer raised; empty without one."""

    @property
    def wall(self) -> SampledWall:
        """Bound of the walls that can be displayed at the present loop period."""
        return self._loop.wall

    @property
    def fault(self) -> Fault | None:
        """The fault that the gate has latched, if any."""
        return self._gate.fault

    @property
    def produced_mj(self) -> dict[str, dict[str, float]]:
        """Energy that came out at each finger beyond what it put in, mJ: `now`, and the `most` in this session."""
        return dict(zip(FINGERS, self._gate.produced_mj, strict=True))

    def step(self, now: RenderingInput, touch: Touch | None, coupling: Coupling = DIRECT) -> GatedOutput:
        """Return the outputs that may reach the devices in this tick.

        Args:
            now: input of this tick.
            touch: the touch packet that `now` names; None without one, or if a recording has lost it.
            coupling: coupling of the hand to the remote hand.
        """
        gate = self._gate
        if now.fault_cleared:
            gate.clear_fault()
        # After a clock was set back, all timed parts would stop until it reaches the old time again.
        if now.time_s < self._time_s or (now.fault_cleared and self._broken):
            self._restart()
        self._time_s = now.time_s
        if now.session != self._session:
            self._session = now.session
            gate.begin_session()
            self.fingertips.begin_session()
        for fault in now.device_faults:
            gate.trip(fault)
        self._loop.step(now.time_s, now.heights_s)
        self.fingertips.show(self.wall)
        wanted = self._requests(now, touch, coupling)
        if self._broken:
            gate.trip(contained(self._broken))
        gate.show(self.wall)
        output = gate.step(
            now.time_s,
            now.engaged and now.located,
            _NO_INPUT_S if now.gap_ns is None else now.gap_ns * 1e-9,
            wanted,
            plate_measured_c=now.plate_c,
            measurement_age_s=now.plate_age_s,
            z_m=now.z_m,
            height_age_s=now.time_s - now.heights_s,
        )
        self.pushed_n = output.force_n
        return output

    def _requests(self, now: RenderingInput, touch: Touch | None, coupling: Coupling) -> Outputs:
        """Return the renderer's requests, neutral if it has failed."""
        if not self._broken:
            try:
                return self._render(now, touch, coupling)
            except Exception as error:
                self.fingertips.impulses_played = []
                self._broken = self._contain.caught("render", error, latches=False)
        return neutral()

    def _render(self, now: RenderingInput, touch: Touch | None, coupling: Coupling) -> Outputs:
        x_m, y_m, z_m = coupling.command(now.x_m, now.y_m, now.z_m)
        fresh = now.gap_ns is not None and now.gap_ns <= self._gap_ns
        touch = touch if fresh else None
        if touch is not self._touch:
            self._touch, self._rows = touch, _NO_TOUCHES if touch is None else touch.rows
        plate_age_s: Sequence[float] = now.plate_age_s
        in_test = self._gate.in_test
        if True in in_test:  # such a plate gets no drive but a test pulse, and its reading is not used
            plate_age_s = [math.inf if test else age_s for test, age_s in zip(in_test, plate_age_s, strict=True)]
        return self.fingertips.step(
            now.time_s,
            now.engaged and fresh and now.located,
            rows=self._rows,
            events=() if touch is None else touch.events,
            speed_m_s=self._speed.step(now.pose_s, x_m, y_m) if now.located else 0.0,
            x_m=x_m,
            y_m=y_m,
            z_m=z_m,
            pushed_n=self.pushed_n,
            plate_c=now.plate_c,
            plate_age_s=plate_age_s,
            coupling=coupling,
            hand_z_m=now.z_m,
        )
