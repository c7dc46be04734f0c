"""Heats the plates of the thermal sensors in use while their fingers are free."""

import math
from collections.abc import Iterable, Mapping

from common.fingers import FINGERS
from remote_site.devices.sensor_frame import PlateReading, SensorFrame
from remote_site.identification.finger_identification import FingerIdentification
from remote_site.thermal.heater_control import OFFSETS_K, STAGGER_K, STALE_S, HeaterControl, next_offset_k


class Heating:
    """Wanted drives of all heaters. Pure: readings and identification in, drives out.

    It restarts together with identification, after an exception in that or after the clock was set back.
    """

    def __init__(self, fingers: Iterable[str]):
        self._numbers = [FINGERS.index(finger) for finger in fingers]
        self._time_s = -math.inf
        self._restart()

    def _restart(self) -> None:
        offsets_k = [OFFSETS_K[0] + stagger_k for stagger_k in STAGGER_K]
        self._heaters = {n: FingerHeating(offset_k) for n, offset_k in zip(self._numbers, offsets_k, strict=False)}

    def step(self, sensed: SensorFrame, touches: Mapping[int, FingerIdentification]) -> list[float]:
        """Return the wanted drive of each heater (5,), -1..1, by this tick's readings and what they identify.

        It is 0 for a finger without identification.
        """
        if not touches or sensed.time_s < self._time_s:
            self._restart()
        self._time_s = sensed.time_s
        drives = [0.0] * len(FINGERS)
        for finger, touch in touches.items():
            thermal, heater = touch.thermal, self._heaters[finger]
            drives[finger] = heater.step(
                sensed.time_s, sensed.plates[finger], thermal.measuring, thermal.no_differences
            )
        return drives


class FingerHeating:
    """One plate's heater.

    Attributes:
        control: controller of the plate; its offset changes where an object is as warm as the plate.
    """

    def __init__(self, preheat_k: float) -> None:
        """Begin with a plate that waits at ambient + `preheat_k`, K."""
        self.control = HeaterControl(preheat_k)
        self._drive = 0.0
        self._reading_s = -math.inf
        self._ambient_c: float | None = None
        self._no_differences = 0

    def step(self, t_s: float, reading: PlateReading | None, measuring: bool, no_differences: int) -> float:
        """Return the wanted drive, -1..1; 0 in a touch and without a recent reading.

        Args:
            t_s: time, s.
            reading: reading of the sensor in this tick; None without a new one.
            measuring: whether a touch uses the plate.
            no_differences: number of touches that ended because plate and object had equal temperatures.
        """
        control = self.control
        if reading is not None:
            self._ambient_c = reading.ambient_c
        if no_differences != self._no_differences:
            self._no_differences = no_differences
            if self._ambient_c is not None:
                control.offset_k = next_offset_k(control.offset_k, self._ambient_c)
        if reading is not None:
            self._reading_s = t_s
            self._drive = control.step(t_s, reading.sensor_c, reading.ambient_c, measuring, reading.reason)
        elif measuring or t_s - self._reading_s > STALE_S:
            self._drive = 0.0
        return self._drive
