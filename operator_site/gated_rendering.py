"""Renderer and gate of the operator site in one step: from a tick's input to what may reach the devices."""

from common.config import RenderingConfig
from common.faults.fault import Fault, contained
from common.fingers import FINGERS
from common.limits import PLATE_PROFILES
from common.runtime.containment import Containment
from operator_site.fingertips import Fingertips
from operator_site.rendering import Rendering
from operator_site.rendering_input import RenderingInput
from operator_site.safety.gated_output import GatedOutput
from operator_site.safety.operator_gate import OperatorGate
from operator_site.safety.sampled_wall import SampledWall

_NO_INPUT_S = 1e9
"""Age of an input that never came."""


class GatedRendering:
    """Passes the renderer's requests through the gate. Pure: one tick's input in, gated output out.

    The gate latches what the renderer raises. What the gate itself raises passes.
    """

    def __init__(self, config: RenderingConfig, period_s: float, gap_s: float, contain: Containment | None = None):
        """Render as configured; the arguments are those of `Rendering`."""
        self._rendering = Rendering(config, period_s, gap_s, contain)
        self._gate = OperatorGate(PLATE_PROFILES[config.profile], self.wall)
        self._session = 0
        self._pushed_n = [0.0] * len(FINGERS)

    @property
    def fingertips(self) -> Fingertips:
        """The renderer, as the last step left it."""
        return self._rendering.fingertips

    @property
    def wall(self) -> SampledWall:
        """The stiffest that can be shown, as the loop runs now."""
        return self._rendering.wall

    @property
    def fault(self) -> Fault | None:
        """The fault that the gate has latched, if any."""
        return self._gate.fault

    @property
    def produced_mj(self) -> dict[str, dict[str, float]]:
        """Energy that came out at each finger beyond what it put in, mJ: `now`, and the `most` in this session."""
        return dict(zip(FINGERS, self._gate.produced_mj, strict=True))

    def step(self, now: RenderingInput) -> GatedOutput:
        """What may reach the devices in this tick."""
        gate, rendering = self._gate, self._rendering
        if now.fault_cleared:
            gate.clear_fault()
        if now.session != self._session:
            self._session = now.session
            gate.begin_session()
        for fault in now.device_faults:
            gate.trip(fault)
        requested = rendering.step(now, self._pushed_n, gate.in_test)
        if rendering.broken:
            gate.trip(contained(rendering.broken))
        gate.show(rendering.wall)
        output = gate.step(
            now.time_s,
            now.engaged and now.located,
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
