"""Makes English texts from the codes of faults and reasons. No other module does this."""

from common.faults.fault import UNITS, Fault, FaultCode, read_fault
from common.wire.messages import ThermalReason
from common.wire.packets import BadPacket

_FAULTS = {
    FaultCode.TIME_NOT_FINITE: "time is not a finite number",
    FaultCode.AGE_NOT_A_NUMBER: "age of the input is not a number",
    FaultCode.REQUEST_NOT_FINITE: "a requested output is not a finite number",
    FaultCode.MOTION_NOT_FINITE: "a requested motion or heater drive is not a finite number",
    FaultCode.MEASUREMENT_NOT_FINITE: "a measurement is not a finite number",
    FaultCode.PLATE_NOT_BELIEVED: "plate temperature is implausible",
    FaultCode.PLATE_TOO_HOT: "plate at {value:.1f} C, above {limit:.1f} C",
    FaultCode.PLATE_AGAINST_DRIVE: "plate temperature moves against the drive",
    FaultCode.PLATE_NOT_FOLLOWING: "plate temperature does not follow the drive",
    FaultCode.PLATE_UNMOVED: "plate temperature does not change although driven",
    FaultCode.PLATE_STILL_DRIVEN: "plate temperature stands still although the drive changes",
    FaultCode.PLATE_STILL_HOT: "plate temperature reading stands still",
    FaultCode.PLATE_STILL_HEATED: "plate temperature reading stands still although heated",
    FaultCode.PLATE_TAKES_HEAT: "plate takes more heat than its reading explains; check its thermistor",
    FaultCode.PLATE_THERMISTOR_SHORT: "the plate's thermistor: short circuit",
    FaultCode.PLATE_THERMISTOR_OPEN: "the plate's thermistor: open circuit",
    FaultCode.PLATE_THERMISTOR_JUMPS: "the plate's thermistor: changes faster than a plate can",
    FaultCode.HOT_SIDE_THERMISTOR_SHORT: "the hot side's thermistor: short circuit",
    FaultCode.HOT_SIDE_THERMISTOR_OPEN: "the hot side's thermistor: open circuit",
    FaultCode.COOLING_LOST: "the cooling water is lost: hot side at {value:.0f} C, {limit:.0f} C before",
    FaultCode.COOLING_TOO_COLD: "the cooling water is lost or too cold: hot side at {value:.0f} C, "
    "{limit:.0f} C before",
    FaultCode.MODULE_CUT_OUT: "the module's own temperature limit has switched its plate off",
    FaultCode.MOTOR_UNASKED: "the motor is driven with {value:.0f} mV without a command",
    FaultCode.PELTIER_UNASKED: "the Peltier element is driven with {value:.0f} permille without a command",
    FaultCode.SENSOR_PLATE_TOO_HOT: "sensor plate at {value:.1f} C, above {limit:.1f} C",
    FaultCode.SENSOR_CUT_OUT: "the sensor's own temperature limit has switched its heater off",
    FaultCode.HEATER_UNASKED: "the heater is driven with {value:.0f} permille without a command",
    FaultCode.FORCE_SWINGS: "force swings at {rate_hz:.0f} Hz by {value:.1f} N",
    FaultCode.FORCE_UNASKED: "{value:.2f} N applied, {limit:.2f} N commanded",
    FaultCode.DRIVES_UNASKED: "the drives are enabled without a command",
    FaultCode.NOT_RELEASED: "it is not released, although commanded",
    FaultCode.SET_POINT_MISSED: "does not obey: {value:.1f} mm off its set-points, at most {limit:.1f} mm",
    FaultCode.STATE_NOT_REPORTED: "reports its position, but not the state of its outputs",
    FaultCode.ENCODER_JUMPED: "encoder jumped by {value:.1f} mm",
    FaultCode.ENCODER_JUMPS: "encoder jumps: {value:.0f} times in 1 s, at most {limit:.0f}",
    FaultCode.ENCODER_STUCK: "joint or encoder stuck: it was sent {value:.1f} mm, and has not moved by a count",
    FaultCode.FINGER_STILL: "height has not changed for {value:.1f} s, at most {limit:.1f} s: joint or encoder stuck",
    FaultCode.FORCE_SENSOR_FROZEN: "force sensor frozen at {value:.2f} N",
    FaultCode.FORCE_SENSOR_DEAD: "force sensor dead: it reads {detail}, but the finger is held {value:.1f} mm "
    "above its set-point, at most {limit:.1f} mm",
    FaultCode.FORCE_SENSOR_BIASED: "force sensor biased: {value:.2f} N, of which the servo shows {limit:.2f} N",
    FaultCode.BUS_OFF: "CAN bus is off: the controller of {detail} has left it after too many errors",
    FaultCode.FOREIGN_FRAMES: "another node sends this frame: only this site may",
    FaultCode.FRAMES_DAMAGED: "{value:.0f} of the last {detail} frames damaged, at most {limit:.0f}",
    FaultCode.NO_GOOD_FRAME: "no good frame for {value:.0f} ms, at most {limit:.0f} ms: only damaged ones",
    FaultCode.KEY_USED_TWICE: "the operator's key is in use at two places at once: revoke it and make a new one",
    FaultCode.OPERATOR_STOP: "emergency stop by the operator",
    FaultCode.REMOTE_STOP: "emergency stop at the remote site",
    FaultCode.PATIENT_STOP: "patient stopped: the patient pressed the stop switch",
    FaultCode.PATIENT_SWITCH_FAILED: "the patient's stop switch {detail}",
    FaultCode.CONTAINED: "{detail}",
    FaultCode.UNKNOWN: "unknown fault {detail}",
}
_NEEDS_TEST = "; again within 10 min: this plate stays off until a small test pulse has moved it"
_THERMAL = {
    ThermalReason.NONE: "",
    ThermalReason.NO_DIFFERENCE: "no temperature difference",
    ThermalReason.NO_FIT: "the response is that of no material",
    ThermalReason.NOT_CALIBRATED: "matches nothing calibrated",
    ThermalReason.NOT_RULED_OUT: "something that was not calibrated is not ruled out",
    ThermalReason.CONTACT_LOST: "contact lost",
    ThermalReason.STROKED: "stroked: the touch did not rest",
    ThermalReason.STILL_WARM: "the spot is still warm from the last touch: wait, or touch beside it",
    ThermalReason.TOUCHED_BEFORE: "touched here just before",
    ThermalReason.NO_READING: "sensor fault: no reading",
    ThermalReason.READINGS_MISSING: "sensor fault: readings missing",
    ThermalReason.NOT_A_NUMBER: "sensor fault: a reading is no number",
    ThermalReason.READING_STUCK: "sensor fault: the reading does not change, saturated or stuck",
    ThermalReason.SENSOR_SHORTED: "sensor fault: thermal sensor shorted",
    ThermalReason.SENSOR_OPEN: "sensor fault: thermal sensor open",
    ThermalReason.SENSOR_JUMPS: "sensor fault: thermal sensor jumps",
    ThermalReason.SENSOR_FROZEN: "sensor fault: thermal sensor does not follow its heater",
}


def fault_text(fault: Fault | None) -> str:
    """Return a fault as one line: device, place, and kind with value and limit; empty for none."""
    if fault is None:
        return ""
    what = filled(_FAULTS[fault.code], fault) + (_NEEDS_TEST if fault.needs_test else "")
    return ": ".join(filter(None, (fault.device, fault.where, what)))


def filled(text: str, fault: Fault) -> str:
    """Return a text with the fault's numbers filled in; a question mark stands for an unknown number."""
    numbers = {name: _Number(getattr(fault, name)) for name in ("value", "limit", "rate_hz")}
    return text.format(detail=fault.detail, **numbers)


def fault_figures(fault: Fault | None) -> dict[str, object] | None:
    """Return a fault for a status file: each field by its name, the unit of the numbers, and the text."""
    if fault is None:
        return None
    return {**fault._asdict(), "unit": UNITS.get(fault.code, ""), "text": fault_text(fault)}


def said_fault(value: object) -> str:
    """Return the text of a fault in a status file or in the answer to a local command; empty for none."""
    try:
        return fault_text(read_fault(value))
    except BadPacket:
        return "unknown fault"


def thermal_text(reason: ThermalReason) -> str:
    """Return why a material is not named, or does not come from this touch alone; empty for NONE."""
    return _THERMAL[reason]


class _Number:
    """A number for `str.format` that may be unknown."""

    def __init__(self, number: float | None) -> None:
        self._number = number

    def __format__(self, spec: str) -> str:
        return "?" if self._number is None else format(self._number, spec)
