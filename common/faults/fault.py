"""Defines the faults that sites latch: a code with a place and numbers. `common.faults.texts` has the words."""

import math
from collections.abc import Mapping
from enum import StrEnum
from typing import NamedTuple

from common.files.printable import one_line
from common.fingers import FINGERS
from common.wire.packets import MAX_TEXT, BadPacket

LONGEST_DETAIL = 300
"""Maximum length of a fault's free text, characters."""
AXES = ("hand's x", "hand's y")
"""Values of `Fault.where` for a fault of the hand's position, which belongs to no finger."""
EXOSKELETON, TELEMANIPULATOR = "exoskeleton", "telemanipulator"


class FaultCode(StrEnum):
    """Kind of fault. Packets, status files and recordings contain the values."""

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
    PLATE_TAKES_HEAT = "plate-takes-more-heat"
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
    PATIENT_STOP = "patient-stop"
    PATIENT_SWITCH_FAILED = "patient-switch-failed"
    CONTAINED = "exception-contained"
    UNKNOWN = "unknown"
    """Code of a far site that this version does not have; the fault's detail contains it."""


STOPS = frozenset((FaultCode.OPERATOR_STOP, FaultCode.REMOTE_STOP))
"""Codes of emergency stops, which a person requested."""
PERSONS_STOPS = (FaultCode.OPERATOR_STOP, FaultCode.REMOTE_STOP, FaultCode.UNKNOWN, FaultCode.PATIENT_STOP)
"""Codes of the stops that survive a restart of the remote site, because a person requested them; a later one takes the
place of an earlier one. UNKNOWN is a stop whose file is damaged."""
OF_THE_PATIENT = (FaultCode.PATIENT_SWITCH_FAILED, FaultCode.PATIENT_STOP)
"""Codes of the patient's stop; see `replaces`. Only a person at the remote site may clear such a fault."""
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
        FaultCode.PLATE_TAKES_HEAT,
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
"""Codes of faults of one finger's plate, module or thermal sensor. After a repeated one it needs a test pulse."""
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
"""Unit of value and limit for each code that has a value; empty for a count."""


class Fault(NamedTuple):
    """One fault. Packets and recordings contain it as a tuple.

    Attributes:
        code: kind of fault.
        where: finger, one of AXES, or CAN frame; empty for a fault of a whole device or site.
        device: EXOSKELETON or TELEMANIPULATOR for a fault of one of them; else empty.
        value: measured value, in the unit of the code; None for a code without a value.
        limit: value with which `value` is compared, in the same unit; None for a code without one.
        rate_hz: frequency of an oscillating force, Hz.
        detail: place of a contained exception, address of a bus, number of examined frames, reading of a dead force
            sensor, what is wrong with the patient's switch, or an unknown code; else empty.
        needs_test: whether the fault is a repeated one: its plate stays off until a test pulse has moved it.
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
        """Number of the finger whose plate, module or thermal sensor has the fault; None for other faults."""
        return FINGERS.index(self.where) if self.code in OF_A_PLATE and self.where in FINGERS else None

    def bounded(self) -> "Fault":
        """Return this fault as every reader accepts it: finite numbers, texts of one bounded printable line."""
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


def replaces(code: FaultCode, latched: FaultCode) -> bool:
    """Return whether a fault takes the place of a latched one, as the patient's does.

    A press takes the place of a failed switch.
    """
    order = OF_THE_PATIENT
    return code in order and (latched not in order or order.index(code) > order.index(latched))


def contained(name: str) -> Fault:
    """Return the fault of a contained exception with this name."""
    return Fault(FaultCode.CONTAINED, detail=name)


def read_fault(value: object) -> Fault | None:
    """Return the fault in a packet, a recording or a status file; None for none. An unknown code becomes UNKNOWN.

    Args:
        value: fields of a `Fault` in order, or a map that contains them by name.

    Raises:
        BadPacket: the value is no fault; the message names the wrong field.
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
