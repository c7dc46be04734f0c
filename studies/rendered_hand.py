"""A hand with five simulated TactTips, rendered by the operator site on virtual time: no network, no processes."""

import math

import numpy as np

from common.config import RenderingConfig
from common.fingers import FINGERS
from common.limits import GAP_S
from common.messages import Touch
from common.serial_messages import DRIVE_FULL
from operator_site.gate import GatedOutput
from operator_site.motor_drive import MotorDrive
from operator_site.ntc import PlateSensor
from operator_site.rendering import Rendering
from operator_site.rendering_input import RenderingInput
from sim_sensors.finger_plate import FingerPlates
from sim_sensors.motor import VibrationMotors
from sim_sensors.tacttip import ntc_counts

SESSION = 1
TICK_S = 0.002
READ_EVERY = 5
"""Ticks between two reports of a module: 100 Hz."""
COMMAND_EVERY = 2
"""Ticks between two commands to a module: 250 Hz."""


class RenderedHand:
    """Rendering with its gate, and the plates and motors under the fingers.

    Attributes:
        time_s: virtual time.
        output: what the gate let through last; None before the first tick.
        plates: plates, with the fingertips on them.
        motors: vibration motors.
    """

    def __init__(self, seed: int, config: RenderingConfig | None = None) -> None:
        """Fingers from the air on plates as warm as they are; `seed` is the plates' sensors'."""
        self._rendering = Rendering(config or RenderingConfig(), GAP_S)
        self.plates, self.motors = FingerPlates(len(FINGERS), seed), VibrationMotors(len(FINGERS))
        self.time_s = 0.0
        self.output: GatedOutput | None = None
        self._sensors = [PlateSensor() for _ in FINGERS]
        self._plate_c = (math.nan,) * len(FINGERS)
        self._read_s = -math.inf
        self._drives = [MotorDrive() for _ in FINGERS]
        self._volts, self._heat = np.zeros(len(FINGERS)), np.zeros(len(FINGERS))
        self._ticks = 0

    def step(self, touch: Touch | None, x_m: float, z_m: float) -> GatedOutput:
        """Let a tick pass with the newest touch packet, None before the first; the hand is at x, its fingertips at z.

        Raises:
            RuntimeError: the gate has found a fault, and nothing is rendered any more.
        """
        if self._ticks % READ_EVERY == 0:
            readings = zip(self._sensors, self.plates.ntc_c.tolist(), strict=True)
            self._plate_c = tuple(sensor.step(self.time_s, ntc_counts(ntc_c)).plate_c for sensor, ntc_c in readings)
            self._read_s = self.time_s
        output = self._rendering.step(
            RenderingInput(
                time_s=self.time_s,
                session=SESSION,
                fault_cleared=False,
                engaged=True,
                gap_ns=None if touch is None else 0,
                touch=touch,
                x_m=x_m,
                y_m=0.0,
                z_m=(z_m,) * len(FINGERS),
                pose_s=self.time_s,
                heights_s=self.time_s,
                plate_c=self._plate_c,
                plate_age_s=(self.time_s - self._read_s,) * len(FINGERS),
                device_faults=(),
            )
        )
        if output.fault is not None:
            raise RuntimeError(f"the gate stopped the study: {output.fault}")
        if self._ticks % COMMAND_EVERY == 0:
            speeds = zip(self._drives, output.motor_rpm, strict=True)
            self._volts = np.array([1e-3 * drive.step(self.time_s, rpm) for drive, rpm in speeds])
            self._heat = np.round(np.array(output.peltier_drive) * DRIVE_FULL) / DRIVE_FULL
        self.plates.step(TICK_S, self._heat)
        self.motors.step(TICK_S, self._volts)
        self._ticks += 1
        self.time_s += TICK_S
        self.output = output
        return output
