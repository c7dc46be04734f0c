"""Faults for tests: any, and for each code those that a site may find."""

from hypothesis import strategies as st

from common.faults.fault import AXES, EXOSKELETON, LONGEST_DETAIL, TELEMANIPULATOR, UNITS, Fault, FaultCode
from common.fingers import FINGERS
from common.wire.packets import MAX_TEXT

_numbers = st.one_of(st.none(), st.floats(allow_nan=False, allow_infinity=False))
_printable = st.characters(exclude_categories=("C", "Z"))
faults = st.builds(
    Fault,
    st.sampled_from(FaultCode),
    st.sampled_from(["", *FINGERS, *AXES, "HandPose"]),
    st.sampled_from(["", EXOSKELETON, TELEMANIPULATOR]),
    _numbers,
    _numbers,
    _numbers,
    st.text(_printable, max_size=LONGEST_DETAIL),
    st.booleans(),
)
LARGE = Fault(FaultCode.CONTAINED, "x" * MAX_TEXT, "y" * MAX_TEXT, 1e300, 1e300, 1e300, "z" * LONGEST_DETAIL, True)
_WITHOUT_LIMIT = frozenset(
    (
        FaultCode.MOTOR_UNASKED,
        FaultCode.PELTIER_UNASKED,
        FaultCode.HEATER_UNASKED,
        FaultCode.FORCE_SWINGS,
        FaultCode.ENCODER_JUMPED,
        FaultCode.ENCODER_STUCK,
        FaultCode.FORCE_SENSOR_FROZEN,
    )
)
_OF_A_SITE = frozenset(
    (
        FaultCode.TIME_NOT_FINITE,
        FaultCode.AGE_NOT_A_NUMBER,
        FaultCode.REQUEST_NOT_FINITE,
        FaultCode.MOTION_NOT_FINITE,
        FaultCode.KEY_USED_TWICE,
        FaultCode.OPERATOR_STOP,
        FaultCode.REMOTE_STOP,
        FaultCode.PATIENT_STOP,
        FaultCode.PATIENT_SWITCH_FAILED,
        FaultCode.CONTAINED,
        FaultCode.UNKNOWN,
    )
)
_OF_A_DEVICE = frozenset(
    (
        FaultCode.MEASUREMENT_NOT_FINITE,
        FaultCode.DRIVES_UNASKED,
        FaultCode.NOT_RELEASED,
        FaultCode.STATE_NOT_REPORTED,
        FaultCode.BUS_OFF,
    )
)
_OF_A_FRAME = frozenset((FaultCode.FOREIGN_FRAMES, FaultCode.FRAMES_DAMAGED, FaultCode.NO_GOOD_FRAME))
_OF_AN_AXIS = frozenset((FaultCode.SET_POINT_MISSED, FaultCode.ENCODER_JUMPED, FaultCode.ENCODER_JUMPS))
_LARGEST = {"C": 60.0, "mV": 2500.0, "permille": -1000.0, "N": 10.23, "mm": 655.3, "s": 99.9, "ms": 999.0, "": 50.0}
"""Of each unit: what devices can report, and what faults may count."""


def examples(code: FaultCode) -> list[Fault]:
    """Faults of a code as sites find them, with the largest numbers, at each place that has one."""
    value = _LARGEST[UNITS[code]] if code in UNITS else None
    limit = value if value is not None and code not in _WITHOUT_LIMIT else None
    rate_hz = 49.9 if code is FaultCode.FORCE_SWINGS else None
    detail = "x" * LONGEST_DETAIL if code in (FaultCode.CONTAINED, FaultCode.UNKNOWN) else ""
    fault = Fault(code, "", "", value, limit, rate_hz, detail)
    if code in _OF_A_SITE:
        return [fault]
    devices = [fault._replace(device=device) for device in (EXOSKELETON, TELEMANIPULATOR)]
    if code in _OF_A_DEVICE:
        return devices
    if code in _OF_A_FRAME:
        frames = ("FingerForces", "FingerHeightsMeasured", "TelemanipulatorState")
        return [each._replace(where=frame) for each in devices for frame in frames]
    places = (*FINGERS, *AXES) if code in _OF_AN_AXIS else FINGERS
    return [fault._replace(where=place) for place in places]
