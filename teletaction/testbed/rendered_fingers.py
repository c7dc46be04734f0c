"""Run half a session: rendering and its gate with five simulated fingertip modules, without exoskeleton or link."""

import math
from collections import deque

import numpy as np

from common.buses.serial_messages import DRIVE_FULL, MessageId, TactTipCommand, encode_frame
from common.config.site_models import RenderingConfig
from common.faults.texts import fault_text
from common.fingers import FINGERS
from common.limits import GAP_S
from common.wire.messages import Touch
from operator_site.devices.ntc import PlateSensor
from operator_site.gated_rendering import GatedRendering
from operator_site.recorded_rows import RenderingInput
from operator_site.safety.gated_output import GatedOutput
from operator_site.vibration.motor_drive import MotorDrive
from sim_sensors.devices.tacttip import TactTip, ntc_counts
from sim_sensors.physics.finger_plate import FingerPlates
from sim_sensors.physics.motor import VibrationMotors

SESSION = 1
TICK_S = 0.002
READ_S = 0.010
"""Time between two reports of a module, s."""
COMMAND_S = 0.004
"""Time between two commands to a module, s."""
_ROUNDING_S = 1e-9


class RenderedFingers:
    """Rendering with its gate, and the plates and motors under the fingers.

    Attributes:
        time_s: virtual time, s.
        output: last output of the gate; None before the first tick.
        plates: plates, with the fingertips on them.
        motors: vibration motors.
    """

    def __init__(
        self,
        seed: int,
        config: RenderingConfig | None = None,
        *,
        tick_s: float = TICK_S,
        noise_k: float = 0.0,
        delay_s: float = 0.0,
    ) -> None:
        """Start with fingers from free air on plates of the same temperature.

        Args:
            seed: seed of the noise of the plates' sensors.
            config: configuration of rendering.
            tick_s: period of rendering, s, a multiple of 1 ms.
            noise_k: standard deviation of additional noise on a plate's reading, K.
            delay_s: delay of a reading, s.
        """
        self._rendering = GatedRendering(config or RenderingConfig(), tick_s, GAP_S)
        self.plates, self.motors = FingerPlates(len(FINGERS), seed), VibrationMotors(len(FINGERS))
        self.time_s = 0.0
        self.output: GatedOutput | None = None
        self._tick_s, self._noise_k, self._delay_s = tick_s, noise_k, delay_s
        self._parts = max(1, math.ceil(tick_s / TICK_S - _ROUNDING_S))
        self._noise = np.random.default_rng([seed, 0xDE1A])
        self._sensors = [PlateSensor() for _ in FINGERS]
        self._readings: deque[tuple[float, list[int]]] = deque()
        self._plate_c = (math.nan,) * len(FINGERS)
        self._read_s = self._commanded_s = -math.inf
        self._drives = [MotorDrive() for _ in FINGERS]
        self._modules = [TactTip(finger) for finger in range(len(FINGERS))]

    def step(self, touch: Touch | None, x_m: float, z_m: float) -> GatedOutput:
        """Advance by a tick with the newest touch packet, None before the first; the hand is at x, its fingertips at z.

        Raises:
            RuntimeError: the gate has found a fault, and rendering has stopped.
        """
        self._read()
        output = self._rendering.step(
            RenderingInput(
                time_s=self.time_s,
                session=SESSION,
                fault_cleared=False,
                engaged=True,
                gap_ns=None if touch is None else 0,
                touch=None if touch is None else touch.sequence,
                x_m=x_m,
                y_m=0.0,
                z_m=(z_m,) * len(FINGERS),
                pose_s=self.time_s,
                heights_s=self.time_s,
                plate_c=self._plate_c,
                plate_age_s=(self.time_s - self._read_s,) * len(FINGERS),
                device_faults=(),
            ),
            touch,
        )
        if output.fault is not None:
            raise RuntimeError(f"the gate stopped the study: {fault_text(output.fault)}")
        if self.time_s - self._commanded_s >= COMMAND_S - _ROUNDING_S:
            self._commanded_s = self.time_s
            self._command(output)
        drive, part_s = np.array([module.drive for module in self._modules]), self._tick_s / self._parts
        for part in range(self._parts):
            now_s = self.time_s + part * part_s
            self.plates.step(part_s, drive)
            self.motors.step(part_s, np.array([module.motor_v(now_s, now_s + part_s) for module in self._modules]))
        self.time_s += self._tick_s
        self.output = output
        return output

    @property
    def stiffest_n_m(self) -> float:
        """Stiffness of the stiffest rendered wall, N/m."""
        return self._rendering.wall.stiffest_n_m

    def _command(self, output: GatedOutput) -> None:
        """Command the modules."""
        wanted = zip(self._modules, self._drives, output.motor_rpm, output.peltier_drive, strict=True)
        for module, drive, rpm, heat in wanted:
            drive.step(self.time_s, rpm)
            command = TactTipCommand(drive.hold_mv, round(heat * DRIVE_FULL), *drive.pulse)
            module.feed(encode_frame(MessageId.TACTTIP_COMMAND, 0, command.encode()), self.time_s)

    def _read(self) -> None:
        """Take the plates' readings, delayed by `delay_s`."""
        if self.time_s - self._read_s < READ_S - _ROUNDING_S:
            return
        self._read_s = self.time_s
        noisy = self.plates.ntc_c + self._noise_k * self._noise.standard_normal(len(FINGERS))
        self._readings.append((self.time_s, [ntc_counts(ntc_c) for ntc_c in noisy.tolist()]))
        while len(self._readings) > 1 and self._readings[1][0] <= self.time_s - self._delay_s + _ROUNDING_S:
            self._readings.popleft()
        counts = zip(self._sensors, self._readings[0][1], strict=True)
        self._plate_c = tuple(sensor.step(self.time_s, each).plate_c for sensor, each in counts)
