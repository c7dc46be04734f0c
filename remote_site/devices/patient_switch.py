"""Driver of the patient's stop switch: its contact, its pain slider, and whether its line and frames are sound."""

import math

from common.buses.serial_device import SerialDevice
from common.buses.serial_messages import SLIDER_FULL, DeviceKind, FrameReader, PatientSwitchState
from common.buses.wiring import SYSTEM, Wiring
from common.fingers import FINGERS
from common.limits import SWITCH_LOST_S
from common.tenderness.presses import WORST_PAIN
from remote_site.safety.patient_stop import SwitchReading

_BYTES_PER_S = 100 * 11
"""Data rate of the switch's reports on its serial line, bytes/s."""


class PatientSwitch:
    """Reads the switch's reports, 100 a second."""

    def __init__(self, port: str, wiring: Wiring = SYSTEM) -> None:
        """Open the switch at `port` in the background."""
        self.line = SerialDevice(port, DeviceKind.PATIENT_SWITCH, FINGERS[0], wiring)
        self.measured_s = -math.inf
        """Time of arrival of the last report, s; -inf before the first."""
        self.pain: float | None = None
        """Newest pain answer, 0..10; NaN once a slider is no longer reported, None from a device without one."""
        self._closed = True
        self._wrong = ""
        self._reader: FrameReader | None = None
        self._bad = 0

    def read(self, t_s: float) -> None:
        """Take the reports since the last call, at `t_s`, s."""
        reports = self.line.poll(PatientSwitchState)
        if reports:
            self._closed = all(report.closed for report in reports)
            self.measured_s = t_s
            pain = reports[-1].pain_permille
            without = None if self.pain is None else math.nan
            self.pain = without if pain is None else WORST_PAIN * pain / SLIDER_FULL
        self._wrong = self._inspect(bool(reports))

    def reading(self, t_s: float) -> SwitchReading:
        """Return what is known of the switch at `t_s`, s."""
        return SwitchReading(self._closed, t_s - self.measured_s, self._wrong)

    def pain_reading(self, t_s: float) -> float | None:
        """Return the pain answer at `t_s`, 0..10; NaN while it is too old, None without a slider."""
        if self.pain is None:
            return None
        return self.pain if 0.0 <= t_s - self.measured_s <= SWITCH_LOST_S else math.nan

    @property
    def pressed(self) -> bool:
        """Whether the newest reports say that the patient presses the switch."""
        return not self._closed

    @property
    def unread_s(self) -> float:
        """Duration of the reports that wait to be read, s."""
        return self.line.unread_bytes() / _BYTES_PER_S

    def _inspect(self, reported: bool) -> str:
        """Return what is wrong with line or frames since the last call; empty when nothing is."""
        if not self.line.connected:
            return "is unplugged" if self.measured_s > -math.inf else ""
        reader = self.line.reader
        bad = reader.damaged + reader.malformed + reader.repeated
        if reader is self._reader:
            worse, self._bad = bad > self._bad, bad
            return "sends wrong frames" if worse else ""
        if reported:  # a connection begins in the middle of a frame: damage counts from its first report
            self._reader, self._bad = reader, bad
        return ""
