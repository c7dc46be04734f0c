"""Pre-heating of the thermal sensors in use: each plate waits warm while its finger is free."""

import math
from collections.abc import Iterable, Mapping

from common.fingers import FINGERS
from common.wire.messages import THERMAL_REASONS
from remote_site.devices.sensor_frame import SensorFrame
from remote_site.devices.thermal_sensor import PlateReading
from remote_site.identification.finger_touch import FingerTouch
from remote_site.thermal.heater_control import OFFSETS_K, STAGGER_K, STALE_S, HeaterControl, next_offset_k


class Heating:
    """Wanted drives of all heaters. Pure: readings and what is identified in, drives out.

    It begins anew together with identification: after an exception in that, or when the clock was set back.
    """

    def __init__(self, fingers: Iterable[str]):
        """Heat the plates of these fingers."""
        self._numbers = [FINGERS.index(finger) for finger in fingers]
        self._time_s = -math.inf
        self._begin_anew()

    def _begin_anew(self) -> None:
        offsets_k = [OFFSETS_K[0] + stagger_k for stagger_k in STAGGER_K]
        self._heaters = {n: FingerHeating(offset_k) for n, offset_k in zip(self._numbers, offsets_k, strict=False)}

    def step(self, sensed: SensorFrame, touches: Mapping[int, FingerTouch]) -> list[float]:
        """Wanted drive of each heater (5,), -1..1; 0 for a finger that is not identified.

        Args:
            sensed: this tick's readings.
            touches: what is identified from them, by finger number.
        """
        if not touches or sensed.time_s < self._time_s:
            self._begin_anew()
        self._time_s = sensed.time_s
        drives = [0.0] * len(FINGERS)
        for finger, touch in touches.items():
            drives[finger] = self._heaters[finger].step(sensed.time_s, sensed.plates[finger], touch)
        return drives


class FingerHeating:
    """One plate's heater."""

    def __init__(self, preheat_k: float = OFFSETS_K[0]) -> None:
        """Begin with a plate that waits at ambient + `preheat_k`, K."""
        self._control = HeaterControl(preheat_k)
        self._drive = 0.0
        self._reading_s = -math.inf
        self._ambient_c: float | None = None
        self._no_differences = 0

    @property
    def preheat_k(self) -> float:
        """Offset of the plate's set-point above ambient, K."""
        return self._control.offset_k

    def step(self, t_s: float, reading: PlateReading | None, touch: FingerTouch) -> float:
        """Wanted drive, -1..1; 0 in a touch and without a recent reading.

        Args:
            t_s: time, s.
            reading: of the sensor in this tick; None where nothing new came.
            touch: what is identified in this tick.
        """
        control = self._control
        if reading is not None:
            self._ambient_c = reading.ambient_c
        if touch.no_differences != self._no_differences:
            self._no_differences = touch.no_differences
            if self._ambient_c is not None:
                control.offset_k = next_offset_k(control.offset_k, self._ambient_c)
        if reading is not None:
            self._reading_s = t_s
            self._drive = control.step(
                t_s, reading.sensor_c, reading.ambient_c, touch.measuring, fault=THERMAL_REASONS[reading.fault]
            )
        elif touch.measuring or t_s - self._reading_s > STALE_S:
            self._drive = 0.0
        return self._drive
