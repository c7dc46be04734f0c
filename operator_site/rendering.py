"""Renders all fingers at the operator site: computes requests from hand, plates and touch."""

import math
from collections.abc import Sequence

from common.config import RenderingConfig
from common.fingers import FINGERS
from common.limits import PLATE_PROFILES
from common.runtime.containment import Containment
from common.wire.messages import NO_TOUCH, Touch, TouchRow
from operator_site.fingertips import Fingertips, Requested
from operator_site.force.loop_stiffness import LoopStiffness
from operator_site.rendering_input import RenderingInput
from operator_site.safety.sampled_wall import SampledWall
from operator_site.thermal.tissue import Body
from operator_site.vibration.stroke_speed import StrokeSpeed

_NEUTRAL: tuple[TouchRow, ...] = (NO_TOUCH,) * len(FINGERS)
"""Touch rows without contact, rendered while there is no fresh touch."""


class Rendering:
    """Renders touch for all fingers. Pure: it turns the input of one tick into requests.

    An exception in the renderer is contained, and requests are neutral until the fault is cleared.

    Attributes:
        fingertips: the renderer after the last step.
        broken: name of the exception that the renderer raised; empty without one.
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
        self._held = LoopStiffness(SampledWall(config.exoskeleton_damping_n_s_m, period_s, config.exoskeleton_delay_s))
        self._gap_ns = round(gap_s * 1e9)
        self._session = 0
        self._time_s = -math.inf
        self._touch: Touch | None = None
        self._rows = _NEUTRAL
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
        self.broken = ""

    @property
    def wall(self) -> SampledWall:
        """Bound of the walls that can be displayed at the present loop period."""
        return self._held.wall

    def step(self, now: RenderingInput, pushed_n: Sequence[float], in_test: Sequence[bool]) -> Requested:
        """Return the requests of this tick, neutral if the renderer has failed.

        Args:
            now: input of the tick.
            pushed_n: force that the gate let through to each finger in the last tick, N.
            in_test: whether each plate gets no drive except a test pulse; its reading is not used then.
        """
        # After a clock was set back, all timed parts would stop until it reaches the old time again.
        if now.time_s < self._time_s or (now.fault_cleared and self.broken):
            self._restart()
        self._time_s = now.time_s
        if now.session != self._session:
            self._session = now.session
            self.fingertips.begin_session()
        self._held.step(now.time_s, now.heights_s)
        self.fingertips.show(self.wall)
        if not self.broken:
            try:
                return self._render(now, pushed_n, in_test)
            except Exception as error:
                self.fingertips.impulses_played = []
                self.broken = self._contain.caught("render", error, latches=False)
        return Requested.neutral()

    def _render(self, now: RenderingInput, pushed_n: Sequence[float], in_test: Sequence[bool]) -> Requested:
        fresh = now.gap_ns is not None and now.gap_ns <= self._gap_ns
        touch = now.touch if fresh else None
        if touch is not self._touch:
            self._touch, self._rows = touch, _NEUTRAL if touch is None else touch.rows
        plate_age_s: Sequence[float] = now.plate_age_s
        if True in in_test:
            plate_age_s = [math.inf if test else age_s for test, age_s in zip(in_test, plate_age_s, strict=True)]
        return self.fingertips.step(
            now.time_s,
            now.engaged and fresh and now.located,
            rows=self._rows,
            events=() if touch is None else touch.events,
            speed_m_s=self._speed.step(now.pose_s, now.x_m, now.y_m) if now.located else 0.0,
            x_m=now.x_m,
            y_m=now.y_m,
            z_m=now.z_m,
            pushed_n=pushed_n,
            plate_c=now.plate_c,
            plate_age_s=plate_age_s,
        )
