"""The patient-side gate: the last thing before the telemanipulator and the thermal sensors' heaters.

A warm plate and a robot touch a person here. Whatever is asked for, set-points stay in range and in speed, a finger
that presses too hard is taken back, a silent operator means stop and then retreat, and no plate is heated on skin.
Pure: numbers and a time in, numbers out. A fault latches; only `clear_fault` ends it.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntFlag

from common.fingers import FINGERS
from common.limits import (
    CONTACT_FORCE_N,
    DOSE_ABOVE_C,
    DOSE_LIMIT_K_S,
    DOSE_WINDOW_S,
    GAP_S,
    SENSOR_PLATE_C,
)

PLANE_RANGE_M = 0.655
HEIGHT_LOW_M = -0.0100
HEIGHT_HIGH_M = 0.01046
"""What the telemanipulator's frames can say."""
PLANE_SPEED_M_S = 0.30
HEIGHT_SPEED_M_S = 0.10
RETREAT_SPEED_M_S = 0.020
CLEAR_HEIGHT_M = 0.006
"""A retreating finger stops here: hovering height."""
STOP_S = 0.100
"""Between stopping and retreating: a short gap of the network only pauses the hand."""
SERVO_N_M = 1000.0
"""Stiffness of the finger's position servo: a set-point this far below the finger pushes with its product."""
REACTION_S = 0.030
"""Measurement, tick, bus and servo: what a finger still does after it is told otherwise."""
BRAKE_SHARE = 0.9
"""At this share of the force limit a set-point goes no deeper; approaching it, ever slower."""
TOUCHING_N = 0.15
"""More force than this is contact for the heater, whatever the mode says."""
SENSOR_LOW_C = -5.0
SENSOR_HIGH_C = 60.0
"""Outside, it is the read-out that is wrong."""
SENSOR_AGE_S = GAP_S
LOOK_AHEAD_S = 0.5
"""The silicon sensor is this far behind its plate, which is judged by where it will be."""
RATE_LAG_S = 0.2
DOSE_BIN_S = 1.0
DOSE_COAST_S = 2.0
"""Dose that a warm plate still gives after its heater is off is counted before it is given."""
HOLDING_DRIVE = 0.2
SILENT_WORK_S = 0.6
SILENT_K = 0.3
"""More than so much drive above what holds a temperature, in s of full drive, must have moved the reading so far."""


class Limit(IntFlag):
    """Which limits acted on a finger (PLANE on all)."""

    RELEASED = 1
    """Not engaged, motion missing, or a fault: stop, then retreat."""
    PLANE_RANGE = 2
    PLANE_SPEED = 4
    HEIGHT_RANGE = 8
    HEIGHT_SPEED = 16
    FORCE = 32
    """Not lowered further, or taken back, because of the contact force."""
    FORCE_UNKNOWN = 64
    """No fresh force: that finger stops and retreats."""
    HEATER_CONTACT = 128
    SENSOR_UNKNOWN = 256
    """No fresh, plausible or moving sensor reading: heater off."""
    SENSOR_TEMPERATURE = 512
    DOSE = 1024
    HEATER_RANGE = 2048


@dataclass(frozen=True, slots=True)
class GatedCommand:
    """What may reach the telemanipulator and the heaters, and what the gate did."""

    x_m: float
    y_m: float
    z_m: list[float]
    heater_drive: list[float]
    limited: list[int]
    """`Limit` bits of each finger."""
    fault: str | None


class PatientGate:
    """Keeps set-points, doses and the time of the last good motion."""

    def __init__(self, contact_force_n: float = CONTACT_FORCE_N) -> None:
        """A gate with its own force limit, at most the table's.

        Raises:
            ValueError: the limit is not in 0..5 N.
        """
        if not 0.0 < contact_force_n <= CONTACT_FORCE_N:
            raise ValueError(f"contact_force_n must be above 0 and at most {CONTACT_FORCE_N} N, not {contact_force_n}")
        self._force_limit_n = contact_force_n
        self._t_s: float | None = None
        self._fault: str | None = None
        self._plane: tuple[float, float] | None = None
        self._z_m: list[float] = [CLEAR_HEIGHT_M] * len(FINGERS)
        self._stopped_s = 0.0
        self._blind_s = [0.0] * len(FINGERS)
        self._sensors = [_SensorPlate() for _ in FINGERS]

    @property
    def fault(self) -> str | None:
        """The latched fault, if any."""
        return self._fault

    def trip(self, reason: str) -> None:
        """Latch a fault found elsewhere; the first reason is kept."""
        self._fault = self._fault or reason

    def clear_fault(self) -> None:
        """End a latched fault: a deliberate act of a person. Doses are not forgotten."""
        self._fault = None
        for sensor in self._sensors:
            sensor.believe_again()

    def step(
        self,
        t_s: float,
        engaged: bool,
        motion_age_s: float,
        *,
        wanted_x_m: float,
        wanted_y_m: float,
        wanted_z_m: Sequence[float],
        measured_x_m: float,
        measured_y_m: float,
        measured_z_m: Sequence[float],
        force_n: Sequence[float],
        force_age_s: float,
        heater_drive: Sequence[float],
        sensor_c: Sequence[float],
        sensor_age_s: Sequence[float],
        in_contact: Sequence[bool],
    ) -> GatedCommand:
        """Pass wanted motion and heat through every limit.

        Args:
            t_s: time on a steady clock, s.
            engaged: whether both sites agree that outputs may act.
            motion_age_s: since the last accepted motion packet, s.
            wanted_x_m, wanted_y_m, wanted_z_m: where the operator's hand and five fingertips are.
            measured_x_m, measured_y_m, measured_z_m: where the telemanipulator is.
            force_n: contact force of each finger, N.
            force_age_s: age of that measurement, s.
            heater_drive: wanted drive of each sensor's heater, -1..1, positive heats.
            sensor_c: last reading of each sensor plate, C; NaN where it is implausible.
            sensor_age_s: age of each reading, s.
            in_contact: whether each finger is known to touch.
        """
        dt_s = self._elapsed(t_s)
        plane_ok = math.isfinite(measured_x_m + measured_y_m)
        if not math.isfinite(wanted_x_m + wanted_y_m + sum(wanted_z_m) + sum(heater_drive)):
            self.trip("a wanted motion or drive is not a finite number")
        if not (plane_ok and math.isfinite(sum(measured_z_m) + sum(force_n))):
            self.trip("a measurement of the telemanipulator is not a finite number")
        for finger, plate_c in enumerate(sensor_c):
            if SENSOR_PLATE_C < plate_c <= SENSOR_HIGH_C:
                self.trip(f"{FINGERS[finger]}: sensor plate at {plate_c:.1f} C, above {SENSOR_PLATE_C:.1f} C")
        live = engaged and 0.0 <= motion_age_s <= GAP_S and self._fault is None
        limited = [0 if live else Limit.RELEASED.value] * len(FINGERS)
        self._stopped_s = 0.0 if live else self._stopped_s + dt_s
        if self._plane is None and plane_ok:
            self._begin(measured_x_m, measured_y_m, measured_z_m)
        if live:
            self._move_plane(dt_s, wanted_x_m, wanted_y_m, limited)
        force_known = 0.0 <= force_age_s <= GAP_S
        for finger, wanted in enumerate(wanted_z_m):
            pressed = force_n[finger] if force_known else math.nan
            self._move_finger(finger, dt_s, live, wanted, measured_z_m[finger], pressed, limited)
        heat = [
            self._heat(finger, t_s, dt_s, live, drive, sensor_c[finger], sensor_age_s[finger], limited)
            if not (in_contact[finger] or not force_n[finger] <= TOUCHING_N)
            else self._no_heat(finger, t_s, dt_s, sensor_c[finger], sensor_age_s[finger], limited)
            for finger, drive in enumerate(heater_drive)
        ]
        x_m, y_m = self._plane or (0.0, 0.0)
        return GatedCommand(x_m, y_m, list(self._z_m), heat, limited, self._fault)
