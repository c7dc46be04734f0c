"""All that the operator site computes in one step: from hand, plates and touch to what may reach the devices."""

import math

import numpy as np

from common.config import RenderingConfig
from common.containment import Containment
from common.fingers import FINGERS, named_finger
from common.limits import GAP_S, PLATE_PROFILES
from common.messages import TOUCH_FIELDS, Touch
from common.packets import Floats
from operator_site.fingertips import Fingertips, Requested
from operator_site.gate import GatedOutput, OperatorGate
from operator_site.held_force import HeldForce
from operator_site.neutral import neutral_request
from operator_site.rendering_input import RenderingInput
from operator_site.sampled_wall import SampledWall
from operator_site.stroke_speed import StrokeSpeed
from operator_site.tissue import Body

_NO_INPUT_S = 1e9
"""Age of an input that never came."""
_NEUTRAL: Floats = np.zeros((len(FINGERS), len(TOUCH_FIELDS)), dtype=np.float32)
"""Touching nothing: what is rendered while there is no fresh touch."""


class Rendering:
    """Renderer and gate of all fingers. Pure: one tick's input in, gated output out.

    An exception in the renderer is contained: the gate latches it, and requests are neutral until the fault is cleared.
    What the gate itself raises passes.
    """

    def __init__(self, config: RenderingConfig, period_s: float, gap_s: float, contain: Containment | None = None):
        """Render as configured.

        Args:
            config: plate profile, damping and delay of the exoskeleton, temperatures of body and air.
            period_s: of the loop.
            gap_s: without an accepted touch packet for longer, nothing is touched.
            contain: counts and logs what the renderer raises; one of its own by default.
        """
        self._contain = contain or Containment()
        self._config = config
        self._held = HeldForce(SampledWall(config.exoskeleton_damping_n_s_m, period_s, config.exoskeleton_delay_s))
        self._gate = OperatorGate(PLATE_PROFILES[config.profile], self.wall)
        self._gap_ns = round(gap_s * 1e9)
        self._session = 0
        self._time_s = -math.inf
        self._pushed_n = [0.0] * len(FINGERS)
        self._touch: Touch | None = None
        self._block = _NEUTRAL
        self._begin_anew()

    def _begin_anew(self) -> None:
        """A renderer that has felt nothing yet; the gate with its doses and faults stays."""
        config = self._config
        self.fingertips = Fingertips(
            self.wall,
            PLATE_PROFILES[config.profile],
            body=Body(deep_c=config.deep_c, arterial_c=config.deep_c + 1.0, air_c=config.air_c),
            vibration=config.vibration,
        )
        self._speed = StrokeSpeed()
        self._broken = False

    @property
    def wall(self) -> SampledWall:
        """The stiffest that can be shown, as the loop runs now."""
        return self._held.wall

    @property
    def fault(self) -> str | None:
        """The fault that the gate has latched, if any."""
        return self._gate.fault

    @property
    def produced_mj(self) -> dict[str, dict[str, float]]:
        """Energy that came out at each finger beyond what it put in, mJ: `now`, and the `most` in this session."""
        return dict(zip(FINGERS, self._gate.produced_mj, strict=True))

    def step(self, now: RenderingInput) -> GatedOutput:
        """What may reach the devices in this tick."""
        if (
            now.time_s < self._time_s
        ):  # the clock was set back: what was timed by it would stand still until it is there
            self._begin_anew()
        self._time_s = now.time_s
        if now.fault_cleared:
            self._gate.clear_fault()
            if self._broken:
                self._begin_anew()
        if now.session != self._session:
            self._session = now.session
            self.fingertips.begin_session()
            self._gate.begin_session()
        for fault in now.device_faults:
            self._gate.trip(fault, named_finger(fault))
        # Where a finger is not known nothing can be rendered to it: an old place is no place.
        located = now.time_s - min(now.pose_s, now.heights_s) <= GAP_S
        self._held.step(now.time_s, now.heights_s)
        wall = self._held.wall
        self._gate.show(wall)
        self.fingertips.show(wall)
        requested = self._requested(now, located)
        output = self._gate.step(
            now.time_s,
            now.engaged and located,
            _NO_INPUT_S if now.gap_ns is None else now.gap_ns * 1e-9,
            force_n=requested.force_n,
            motor_rpm=requested.motor_rpm,
            plate_set_c=requested.plate_set_c,
            peltier_drive=requested.peltier_drive,
            plate_measured_c=now.plate_c,
            measurement_age_s=now.plate_age_s,
            z_m=now.z_m,
            height_age_s=now.time_s - now.heights_s,
        )
        self._pushed_n = output.force_n
        if any(requested.limited):
            output.limited[:] = [ours | theirs for ours, theirs in zip(output.limited, requested.limited, strict=True)]
        return output

    def _requested(self, now: RenderingInput, located: bool) -> Requested:
        """What the renderer asks for, neutral where it has failed."""
        fresh = now.gap_ns is not None and now.gap_ns <= self._gap_ns
        touch = now.touch if fresh else None
        if not self._broken:
            try:
                if touch is not self._touch:
                    self._touch, self._block = touch, _NEUTRAL if touch is None else touch.block
                plate_age_s = now.plate_age_s
                if True in (in_test := self._gate.in_test):
                    plate_age_s = tuple(
                        [math.inf if test else age_s for test, age_s in zip(in_test, plate_age_s, strict=True)]
                    )
                return self.fingertips.step(
                    now.time_s,
                    now.engaged and fresh and located,
                    touch=self._block,
                    events=() if touch is None else touch.events,
                    speed_m_s=self._speed.step(now.pose_s, now.x_m, now.y_m) if located else 0.0,
                    x_m=now.x_m,
                    y_m=now.y_m,
                    z_m=now.z_m,
                    pushed_n=self._pushed_n,
                    plate_c=now.plate_c,
                    plate_age_s=plate_age_s,
                )
            except Exception as error:
                self._broken = True
                self.fingertips.impulses_played = []
                self._gate.trip(self._contain.caught("render", error, latches=False))
        return neutral_request()
