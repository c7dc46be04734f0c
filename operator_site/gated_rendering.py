"""Renders all fingers and passes the gate: from a tick's input to the outputs that may reach the devices.

The input and the touch packet that it names are recorded, and replay renders the same outputs from them.
"""

import math
from collections.abc import Sequence

from common.config.site_models import RenderingConfig
from common.faults.fault import Fault, contained
from common.fingers import FINGERS
from common.limits import PLATE_PROFILES
from common.runtime.containment import Containment
from common.wire.messages import NO_TOUCH, Touch
from operator_site.coupling.coupling import DIRECT, Coupling, Places
from operator_site.fingertips import Fingertips
from operator_site.force.loop_stiffness import LoopStiffness
from operator_site.recorded_rows import RenderingInput
from operator_site.safety.gated_output import GatedOutput, Outputs, neutral
from operator_site.safety.operator_gate import OperatorGate
from operator_site.safety.sampled_wall import SampledWall
from operator_site.thermal.tissue import Body
from operator_site.vibration.stroke_speed import StrokeSpeed

_NO_TOUCHES = (NO_TOUCH,) * len(FINGERS)
"""Touch rows without contact, rendered while there is no fresh touch."""
_NO_INPUT_S = 1e9
"""Age of an input that never came, s."""


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
        """Return the outputs that may reach the devices in this tick, through this coupling to the remote hand.

        `touch` is the packet that `now` names; None without one, or if a recording has lost it.
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
        x_m, y_m, z_m = coupling.command(Places(now.x_m, now.y_m, now.z_m))
        fresh = now.gap_ns is not None and now.gap_ns <= self._gap_ns
        touch = touch if fresh else None
        if touch is not self._touch:
            self._touch, self._rows = touch, _NO_TOUCHES if touch is None else touch.rows
        plate_age_s: Sequence[float] = now.plate_age_s
        undriven = self._gate.undriven
        if True in undriven:  # the reading of such a plate is not used
            plate_age_s = [math.inf if off else age_s for off, age_s in zip(undriven, plate_age_s, strict=True)]
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
