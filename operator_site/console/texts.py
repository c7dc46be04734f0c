"""Every word that the console says: where, what with value and limit, what to do; at most 60 characters in an alarm."""

import re
from collections.abc import Sequence

from common.faults.fault import EXOSKELETON, TELEMANIPULATOR, Fault, FaultCode
from common.faults.texts import filled
from common.limits import PLATE_FAULT_C
from common.wire.messages import ThermalReason, ThermalStatus
from common.wire.touch_summary import TouchSummary

LONGEST_ALARM = 60
_FAULTS = {
    FaultCode.TIME_NOT_FINITE: "time is no number",
    FaultCode.AGE_NOT_A_NUMBER: "age of the input is no number",
    FaultCode.REQUEST_NOT_FINITE: "an output is no number",
    FaultCode.MOTION_NOT_FINITE: "motion is no number",
    FaultCode.MEASUREMENT_NOT_FINITE: "reading is no number",
    FaultCode.PLATE_NOT_BELIEVED: "plate reading is wrong",
    FaultCode.PLATE_TOO_HOT: "plate {value:.1f} °C, over {limit:.1f}",
    FaultCode.PLATE_AGAINST_DRIVE: "plate against its drive",
    FaultCode.PLATE_NOT_FOLLOWING: "plate not following",
    FaultCode.PLATE_UNMOVED: "plate reading not moving",
    FaultCode.PLATE_STILL_DRIVEN: "plate reading stands still",
    FaultCode.PLATE_STILL_HOT: "hot plate reading is still",
    FaultCode.PLATE_STILL_HEATED: "heated reading is still",
    FaultCode.PLATE_THERMISTOR_SHORT: "plate sensor short",
    FaultCode.PLATE_THERMISTOR_OPEN: "plate sensor open",
    FaultCode.PLATE_THERMISTOR_JUMPS: "plate sensor jumps",
    FaultCode.HOT_SIDE_THERMISTOR_SHORT: "hot side sensor short",
    FaultCode.HOT_SIDE_THERMISTOR_OPEN: "hot side sensor open",
    FaultCode.COOLING_LOST: "no water: {value:.0f}, was {limit:.0f} °C",
    FaultCode.COOLING_TOO_COLD: "cold water: {value:.0f}, was {limit:.0f} °C",
    FaultCode.MODULE_CUT_OUT: "module cut its plate off",
    FaultCode.MOTOR_UNASKED: "motor unasked at {value:.0f} mV",
    FaultCode.PELTIER_UNASKED: "plate unasked at {value:.0f} ‰",
    FaultCode.SENSOR_PLATE_TOO_HOT: "plate {value:.1f} °C, over {limit:.1f}",
    FaultCode.SENSOR_CUT_OUT: "sensor cut its heater off",
    FaultCode.HEATER_UNASKED: "heater unasked at {value:.0f} ‰",
    FaultCode.FORCE_SWINGS: "force swings {rate_hz:.0f} Hz, {value:.1f} N",
    FaultCode.FORCE_UNASKED: "force {value:.2f} N, asked {limit:.2f}",
    FaultCode.DRIVES_UNASKED: "drives on, never asked",
    FaultCode.NOT_RELEASED: "does not release",
    FaultCode.SET_POINT_MISSED: "{value:.1f} mm off, limit {limit:.1f}",
    FaultCode.STATE_NOT_REPORTED: "outputs not reported",
    FaultCode.ENCODER_JUMPED: "encoder jumped {value:.1f} mm",
    FaultCode.ENCODER_JUMPS: "encoder jumps, {value:.0f} over {limit:.0f}",
    FaultCode.ENCODER_STUCK: "encoder stuck for {value:.1f} mm",
    FaultCode.FINGER_STILL: "still {value:.1f} s, limit {limit:.1f}",
    FaultCode.FORCE_SENSOR_FROZEN: "force stuck at {value:.2f} N",
    FaultCode.FORCE_SENSOR_DEAD: "force dead, {value:.1f} over {limit:.1f} mm",
    FaultCode.FORCE_SENSOR_BIASED: "force {value:.2f} N, servo {limit:.2f}",
    FaultCode.BUS_OFF: "CAN bus is off",
    FaultCode.FOREIGN_FRAMES: "sent by another node",
    FaultCode.FRAMES_DAMAGED: "{value:.0f} damaged, limit {limit:.0f}",
    FaultCode.NO_GOOD_FRAME: "none for {value:.0f} ms, limit {limit:.0f}",
    FaultCode.KEY_USED_TWICE: "key used at two places",
    FaultCode.OPERATOR_STOP: "emergency stop by the operator",
    FaultCode.REMOTE_STOP: "emergency stop there",
    FaultCode.CONTAINED: "program error: {detail}",
    FaultCode.UNKNOWN: "unknown fault {detail}",
}
"""What is wrong, short enough to stand in an alarm beside where it is."""
_ACTS = {FaultCode.PLATE_TOO_HOT: "Heat is off.", FaultCode.FORCE_SWINGS: "Force is off."}
"""What follows from a fault of the operator's site; from the others, that outputs are off."""
_DEVICES = {EXOSKELETON: "exoskeleton", TELEMANIPULATOR: "arm"}
_REASONS = {
    ThermalReason.NONE: "no reason given",
    ThermalReason.NO_DIFFERENCE: "no temperature difference",
    ThermalReason.NO_FIT: "response fits no material",
    ThermalReason.NOT_CALIBRATED: "matches nothing calibrated",
    ThermalReason.NOT_RULED_OUT: "none calibrated",
    ThermalReason.CONTACT_LOST: "contact lost",
    ThermalReason.STROKED: "finger did not rest",
    ThermalReason.STILL_WARM: "spot still warm, touch beside it",
    ThermalReason.TOUCHED_BEFORE: "touched here just before",
    ThermalReason.NO_READING: "no sensor reading",
    ThermalReason.READINGS_MISSING: "sensor readings missing",
    ThermalReason.NOT_A_NUMBER: "sensor reading no number",
    ThermalReason.READING_STUCK: "sensor reading stuck",
    ThermalReason.SENSOR_SHORTED: "sensor shorted",
    ThermalReason.SENSOR_OPEN: "sensor open",
    ThermalReason.SENSOR_JUMPS: "sensor jumps",
    ThermalReason.SENSOR_FROZEN: "sensor frozen",
}
_ABBREVIATED = frozenset(("abs", "ptfe", "pu", "pvc"))
_SURE = 0.995
"""From here a probability is said to be above 99 %."""
OBSERVER = "OBSERVER. Control is at {who}."
LINK_LOST = "LINK LOST. Outputs are neutral. Wait for the link."
LINK_BACK = "Link is back. Hold C to clear."
DATA_BACK = "Data is back. Hold C to clear."
FAULT_OVER = "Fault is over. Hold C to clear."
STOP_LATE = "Stop was confirmed late. Hold C to clear."
DISK_FULL = "Disk full. Recording stopped, findings are kept."
NOT_RECORDED = "Recording stopped. Check the disk, then start again."
REMOTE_NOT_RECORDED = "Remote recording stopped. Check the remote site."
CONSOLE_NOT_RECORDED = "Console's own record stopped. Findings are kept here."
STUDY_NUMBER = "Use a study number, not a name."
NOT_SOUNDED = "Cannot engage: sound not checked."
GONE_ON = "Console was restarted. Findings and map are kept."
NOTHING_HERE = "Nothing was felt here."


def finger(name: str) -> str:
    """A finger's or device's name at the beginning of a sentence."""
    return name[:1].upper() + name[1:]


def short(text: str) -> str:
    """A text as long as an alarm may be."""
    return text if len(text) <= LONGEST_ALARM else text[: LONGEST_ALARM - 1].rstrip() + "…"


def duration(seconds: float) -> str:
    """Such as `12 min 41 s`."""
    whole = max(0, round(seconds))
    return f"{whole // 60} min {whole % 60} s" if whole >= 60 else f"{whole} s"


def count(number: int, of: str) -> str:
    """Such as `3 findings`."""
    return f"{number} {of}" + ("" if number == 1 else "s")


def percent(probability: float) -> str:
    """A probability; never as certain."""
    return "> 99 %" if probability >= _SURE else f"{probability * 100:.0f} %"


def named(material: str) -> str:
    """A material's name for people."""
    return " ".join(word.upper() if word in _ABBREVIATED else word for word in material.split("_"))


def fault(found: Fault) -> str:
    """A latched fault of the operator's site."""
    device = "" if found.where else _DEVICES.get(found.device, "")
    act = "Engage for a plate test." if found.needs_test else _ACTS.get(found.code, "Outputs are off.")
    return _alarm(found, found.where or device, act)


def remote_fault(found: Fault) -> str:
    """A latched fault of the remote site."""
    where = found.where or _DEVICES.get(found.device, "site")
    return _alarm(found, f"remote {where}", "It stands still.")


def _alarm(found: Fault, where: str, act: str) -> str:
    """Where, what, and what follows from it where there is room."""
    what = filled(_FAULTS[found.code], found).rstrip()
    said = short(finger(f"{where}: {what}." if where else f"{what}."))
    whole = f"{said} {act}"
    return whole if len(whole) <= LONGEST_ALARM else said


def plate_over(name: str, plate_c: float) -> str:
    """A plate beyond what may ever be."""
    return f"{finger(name)}: plate {plate_c:.1f} °C, over {PLATE_FAULT_C:.1f}. Heat is off."


def plate_held(name: str, limit_c: float) -> str:
    """A plate that is kept at its limit."""
    return f"{finger(name)}: plate held at {limit_c:.1f} °C limit. Lift the finger."


def site_slow(rate_hz: object, wanted_hz: object) -> str:
    """A loop that does not hold its rate, Hz; what is no number is left out."""
    known = isinstance(rate_hz, float) and isinstance(wanted_hz, float)
    said = f": {rate_hz:.0f} of {wanted_hz:g} ticks a second" if known else ""
    return f"Site slow{said}. Close other programs."


def link_slow(delay_ms: float, sd_ms: float) -> str:
    """A link that is slower than a hand expects."""
    return f"Link slow: {delay_ms:.0f} ± {max(1.0, sd_ms):.0f} ms. Move slowly."


def device_lost(name: str) -> str:
    """A device that was there."""
    if name == "exoskeleton":
        return "Exoskeleton lost. No force is felt."
    if name == "remote hand":
        return "Remote hand lost. Nothing is felt."
    return f"{finger(name)} module lost. {finger(name)} feels nothing."


def device_absent(name: str) -> str:
    """A device that was never there."""
    return f"{finger(name)} absent." if name in ("exoskeleton", "remote hand") else f"{finger(name)} module absent."


def bus_trouble(name: str, what: str) -> str:
    """A CAN controller that reports errors; the device may still work."""
    return short(f"{finger(name)}: CAN bus {what}. Check its cable.")


def no_data(for_s: float) -> str:
    """The site says nothing."""
    return f"No data for {for_s:.1f} s. Screen is not live."


def not_confirmed(devices: Sequence[str]) -> str:
    """An emergency stop that not all devices have confirmed; names as many as there is room for."""
    names = ["arm" if name == "remote hand" else name for name in devices]
    for shown in range(len(names), 0, -1):
        more = f" + {len(names) - shown}" if shown < len(names) else ""
        text = f"STOP NOT CONFIRMED: {finger(', '.join(names[:shown]))}{more}. Use the hardware switch."
        if len(text) <= LONGEST_ALARM or shown == 1:
            return text
    return "STOP NOT CONFIRMED. Use the hardware switch."


def confirmed(devices: int, after_s: float) -> str:
    """An emergency stop that all devices have confirmed."""
    return f"STOPPED. All {devices} devices confirmed in {after_s:.2f} s."


def decision(
    status: ThermalStatus, reason: ThermalReason, material: str, told: TouchSummary, probability: float
) -> tuple[str, str]:
    """What is known of the object under a finger: a word, and a line.

    Args:
        status: of the identification.
        reason: of the status.
        material: the likeliest one.
        told: its candidates.
        probability: of the likeliest.
    """
    best = f"{named(material)} {percent(probability)}" if material else ""
    candidates = [named(name) for name, _ in told.candidates]
    match status:
        case ThermalStatus.IDENTIFIED:
            return "IDENTIFIED", best
        case ThermalStatus.DECIDING:
            return "DECIDING", f"DECIDING {best}".strip()
        case ThermalStatus.AMBIGUOUS:
            between = " or ".join(candidates[:2]) if len(candidates) > 1 else f"{best} or none calibrated"
            return "AMBIGUOUS", f"AMBIGUOUS: {between}"
        case ThermalStatus.UNKNOWN:
            return "UNKNOWN", f"UNKNOWN: {_REASONS[reason]}"
        case ThermalStatus.UNIDENTIFIABLE:
            return "CANNOT TELL", f"CANNOT TELL: {_REASONS[reason]}"
        case _:
            return "NO CONTACT", "NO CONTACT"


def looks_like_a_name(pseudonym: str) -> bool:
    """Whether a pseudonym may name a person: it has no digit, a date, two words, or one that is no abbreviation."""
    words = re.findall(r"[^\W\d_]{2,}", pseudonym)
    dated = re.search(r"\b\d{1,4}[./-]\d{1,2}[./-]\d{1,4}\b|\b(19|20)\d{6}\b", pseudonym) is not None
    numbered = any(letter.isdigit() for letter in pseudonym)
    return not numbered or dated or len(words) >= 2 or any(len(word) > 2 and not word.isupper() for word in words)


def cut_off(pseudonym: str, findings: int, files: Sequence[str]) -> str:
    """An examination that the machine's restart has ended."""
    return f"Session {pseudonym} was cut off: {count(findings, 'finding')} kept in {', '.join(files)}."


def saved(seconds: float, findings: int, gaps: int) -> str:
    """What was kept of a session."""
    return f"Saved: {duration(seconds)}, {count(findings, 'finding')}, {count(gaps, 'gap')}."
