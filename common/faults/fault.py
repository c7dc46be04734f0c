"""Faults that sites latch: a code with a place and numbers. `common.faults.texts` has the words."""

import math
from collections.abc import Mapping
from enum import StrEnum
from typing import NamedTuple

from common.files.printable import one_line
from common.fingers import FINGERS
from common.wire.packets import MAX_TEXT, BadPacket

LONGEST_DETAIL = 300
"""Characters of a fault's free text."""
AXES = ("hand's x", "hand's y")
"""Where a fault is of the hand's place and of no finger."""
EXOSKELETON, TELEMANIPULATOR = "exoskeleton", "telemanipulator"


class FaultCode(StrEnum):
    """What is wrong. The values stand in packets, status files and recordings."""

    TIME_NOT_FINITE = "time-not-finite"
    AGE_NOT_A_NUMBER = "age-not-a-number"
    REQUEST_NOT_FINITE = "request-not-finite"
    MOTION_NOT_FINITE = "motion-not-finite"
    MEASUREMENT_NOT_FINITE = "measurement-not-finite"
    PLATE_NOT_BELIEVED = "plate-not-believed"
    PLATE_TOO_HOT = "plate-too-hot"
    PLATE_AGAINST_DRIVE = "plate-against-drive"
    PLATE_NOT_FOLLOWING = "plate-not-following"
    PLATE_UNMOVED = "plate-unmoved"
    PLATE_STILL_DRIVEN = "plate-still-while-drive-changes"
    PLATE_STILL_HOT = "plate-still-while-hot"
    PLATE_STILL_HEATED = "plate-still-while-heated"
    PLATE_THERMISTOR_SHORT = "plate-thermistor-short"
    PLATE_THERMISTOR_OPEN = "plate-thermistor-open"
    PLATE_THERMISTOR_JUMPS = "plate-thermistor-jumps"
    HOT_SIDE_THERMISTOR_SHORT = "hot-side-thermistor-short"
    HOT_SIDE_THERMISTOR_OPEN = "hot-side-thermistor-open"
    COOLING_LOST = "cooling-lost"
    COOLING_TOO_COLD = "cooling-too-cold"
    MODULE_CUT_OUT = "module-cut-out"
    MOTOR_UNASKED = "motor-unasked"
    PELTIER_UNASKED = "peltier-unasked"
    SENSOR_PLATE_TOO_HOT = "sensor-plate-too-hot"
    SENSOR_CUT_OUT = "sensor-cut-out"
    HEATER_UNASKED = "heater-unasked"
    FORCE_SWINGS = "force-swings"
    FORCE_UNASKED = "force-unasked"
    DRIVES_UNASKED = "drives-unasked"
    NOT_RELEASED = "not-released"
    SET_POINT_MISSED = "set-point-missed"
    STATE_NOT_REPORTED = "state-not-reported"
    ENCODER_JUMPED = "encoder-jumped"
    ENCODER_JUMPS = "encoder-jumps"
    ENCODER_STUCK = "encoder-stuck"
    FINGER_STILL = "finger-still"
    FORCE_SENSOR_FROZEN = "force-sensor-frozen"
    FORCE_SENSOR_DEAD = "force-sensor-dead"
    FORCE_SENSOR_BIASED = "force-sensor-biased"
    BUS_OFF = "can-bus-off"
    FOREIGN_FRAMES = "foreign-frames"
    FRAMES_DAMAGED = "frames-damaged"
    NO_GOOD_FRAME = "no-good-frame"
    KEY_USED_TWICE = "key-used-twice"
    OPERATOR_STOP = "operator-stop"
    REMOTE_STOP = "remote-stop"
    CONTAINED = "exception-contained"
    UNKNOWN = "unknown"
    """A far site gave a code that this one does not have; it is the detail."""


STOPS = frozenset((FaultCode.OPERATOR_STOP, FaultCode.REMOTE_STOP))
"""Emergency stops: a person asked for them."""
OF_A_PLATE = frozenset(
    (
        FaultCode.PLATE_NOT_BELIEVED,
        FaultCode.PLATE_TOO_HOT,
        FaultCode.PLATE_AGAINST_DRIVE,
        FaultCode.PLATE_NOT_FOLLOWING,
        FaultCode.PLATE_UNMOVED,
        FaultCode.PLATE_STILL_DRIVEN,
        FaultCode.PLATE_STILL_HOT,
        FaultCode.PLATE_STILL_HEATED,
        FaultCode.PLATE_THERMISTOR_SHORT,
        FaultCode.PLATE_THERMISTOR_OPEN,
        FaultCode.PLATE_THERMISTOR_JUMPS,
        FaultCode.HOT_SIDE_THERMISTOR_SHORT,
        FaultCode.HOT_SIDE_THERMISTOR_OPEN,
        FaultCode.COOLING_LOST,
        FaultCode.COOLING_TOO_COLD,
        FaultCode.MODULE_CUT_OUT,
        FaultCode.MOTOR_UNASKED,
        FaultCode.PELTIER_UNASKED,
        FaultCode.SENSOR_PLATE_TOO_HOT,
        FaultCode.SENSOR_CUT_OUT,
        FaultCode.HEATER_UNASKED,
    )
)
"""Faults of one finger's plate, of its module or of its thermal sensor. A repeated one needs a test pulse."""
UNITS = {
    FaultCode.PLATE_TOO_HOT: "C",
    FaultCode.COOLING_LOST: "C",
    FaultCode.COOLING_TOO_COLD: "C",
    FaultCode.MOTOR_UNASKED: "mV",
    FaultCode.PELTIER_UNASKED: "permille",
    FaultCode.SENSOR_PLATE_TOO_HOT: "C",
    FaultCode.HEATER_UNASKED: "permille",
    FaultCode.FORCE_SWINGS: "N",
    FaultCode.FORCE_UNASKED: "N",
    FaultCode.SET_POINT_MISSED: "mm",
    FaultCode.ENCODER_JUMPED: "mm",
    FaultCode.ENCODER_JUMPS: "",
    FaultCode.ENCODER_STUCK: "mm",
    FaultCode.FINGER_STILL: "s",
    FaultCode.FORCE_SENSOR_FROZEN: "N",
    FaultCode.FORCE_SENSOR_DEAD: "mm",
    FaultCode.FORCE_SENSOR_BIASED: "N",
    FaultCode.FRAMES_DAMAGED: "",
    FaultCode.NO_GOOD_FRAME: "ms",
}
"""Unit of value and limit of each code that has a value; empty for a count."""


class Fault(NamedTuple):
    """One fault. As a tuple it is what packets and recordings hold.

    Attributes:
        code: what is wrong.
        where: the finger, one of AXES, or the CAN frame; empty where it is of a whole device or site.
        device: EXOSKELETON or TELEMANIPULATOR, where it is of one of these.
        value: what was measured, in the unit of the code; None where the code has none.
        limit: what the value is compared with; None where the code names none.
        rate_hz: frequency of a force that swings, Hz.
        detail: place of a contained exception, address of a bus, number of frames looked at, reading of a dead force
            sensor, or a code that is not known; else empty.
        needs_test: whether the fault is repeated, and its plate stays off until a test pulse has moved it.
    """

    code: FaultCode
    where: str = ""
    device: str = ""
    value: float | None = None
    limit: float | None = None
    rate_hz: float | None = None
    detail: str = ""
    needs_test: bool = False

    @property
    def plate(self) -> int | None:
        """Number of the finger whose plate, module or thermal sensor the fault is of; None where it is of none."""
        return FINGERS.index(self.where) if self.code in OF_A_PLATE and self.where in FINGERS else None

    def bounded(self) -> "Fault":
        """The same, so that every reader takes it: finite numbers, and texts of one bounded printable line."""
        return Fault(
            self.code,
            one_line(self.where, MAX_TEXT),
            one_line(self.device, MAX_TEXT),
            _finite(self.value),
            _finite(self.limit),
            _finite(self.rate_hz),
            one_line(self.detail, LONGEST_DETAIL),
            self.needs_test,
        )


_CODES = frozenset(FaultCode)


def contained(name: str) -> Fault:
    """The fault of a contained exception with this name."""
    return Fault(FaultCode.CONTAINED, detail=name)


def read_fault(value: object) -> Fault | None:
    """The fault that a packet, a recording or a status file holds; None for none. An unknown code becomes UNKNOWN.

    Args:
        value: the fields of a `Fault` in order, or a map that has them by name and perhaps more.

    Raises:
        BadPacket: it is something else.
    """
    if value is None:
        return None
    if isinstance(value, Mapping):
        value = [value.get(name) for name in Fault._fields]
    if not isinstance(value, (list, tuple)) or len(value) != len(Fault._fields):
        raise BadPacket(f"fault: neither nil nor a list of {len(Fault._fields)} fields")
    code, where, device, *numbers, detail, needs_test = value
    measured, limit, rate_hz = numbers
    if not all(isinstance(text, str) for text in (code, where, device, detail)) or type(needs_test) is not bool:
        raise BadPacket("fault: code, where, device or detail is no text, or needs_test is no boolean")
    if not all(number is None or (type(number) is float and math.isfinite(number)) for number in numbers):
        raise BadPacket("fault: value, limit or rate_hz is neither nil nor a finite number")
    if code not in _CODES:
        code, detail = FaultCode.UNKNOWN, code
    return Fault(FaultCode(code), where, device, measured, limit, rate_hz, detail, needs_test).bounded()


def _finite(number: float | None) -> float | None:
    return float(number) if number is not None and math.isfinite(number) else None
