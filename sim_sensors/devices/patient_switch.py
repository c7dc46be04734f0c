"""Emulate the patient's stop switch: a normally closed contact that is reported 100 times a second."""

import math

from common.buses.serial_messages import (
    SLIDER_FULL,
    BadPayload,
    DeviceKind,
    Frame,
    Identity,
    MessageId,
    PatientSwitchState,
)
from common.limits import SWITCH_HOLD_S
from sim_sensors.devices.plate_module import RATE_HZ, ReportClock
from sim_sensors.devices.serial_module import SerialModule

GONE = -1
"""Fault of the pain slider that is no longer reported."""


class PatientSwitch(SerialModule):
    """Emulated stop switch.

    Attributes:
        pressed: whether the patient presses it.
        hung: fault; the module repeats the bytes of its last report.
        pain: position of the pain slider, 0..1; None for a device without one.
        slider: fault; thousandths that the slider reports wherever it is, GONE for no report of it; None when sound.
    """

    def __init__(self, powered_s: float = 0.0) -> None:
        super().__init__(Identity(DeviceKind.PATIENT_SWITCH, 0, "PS0000", 1, RATE_HZ, 0.0, 1.0), powered_s)
        self.pressed = False
        self.hung = False
        self.pain: float | None = None
        self.slider: int | None = None
        self._reports = ReportClock(1.0 / RATE_HZ, powered_s)
        self._pressed_s = -math.inf
        self._last = b""

    def press(self, now_s: float) -> None:
        """Press and release at once, at `now_s`."""
        self._pressed_s = now_s

    def _obey(self, frame: Frame, now_s: float) -> None:
        raise BadPayload(f"patient switch: no command {frame.message_id:#04x}")

    def _run(self, now_s: float) -> None:
        if self.pressed:
            self._pressed_s = now_s
        if not self._reports.due(now_s):
            return
        if self.hung:
            self._output += self._last
            return
        before = len(self._output)
        closed = now_s - self._pressed_s > SWITCH_HOLD_S
        self._say(MessageId.PATIENT_SWITCH_STATE, self._payload(now_s, closed=closed))
        self._last = self._output[before:]

    def _payload(self, now_s: float, *, closed: bool) -> bytes:
        pain = None if self.pain is None else round(SLIDER_FULL * self.pain)
        if self.slider is not None:
            pain = None if self.slider == GONE else self.slider
        time_us = self._time_us(now_s)
        if pain is None or pain <= SLIDER_FULL:
            return PatientSwitchState(time_us, closed, pain).encode()
        return PatientSwitchState.WITH_SLIDER.pack(time_us & 0xFFFFFFFF, closed, pain)

    def _next_s(self) -> float:
        return -math.inf if self.pressed else self._reports.due_s
