"""Holds every text that the console sends to a page.

An alarm names the place, the problem with its value and limit, and the remedy, in at most LONGEST_ALARM characters.
"""

import re
from collections.abc import Sequence

from common.faults.fault import EXOSKELETON, TELEMANIPULATOR, Fault, FaultCode
from common.faults.texts import filled
from common.limits import PLATE_FAULT_C
from common.wire.messages import ThermalReason, ThermalStatus
from common.wire.touch_summary import TouchSummary
from operator_site.console.camera.camera_now import Seen

LONGEST_ALARM = 64
"""Maximum length of an alarm, characters."""
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
    FaultCode.PLATE_TAKES_HEAT: "plate reads too little",
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
    FaultCode.PATIENT_STOP: "patient stopped",
    FaultCode.PATIENT_SWITCH_FAILED: "patient's switch {detail}",
    FaultCode.CONTAINED: "program error: {detail}",
    FaultCode.UNKNOWN: "unknown fault {detail}",
}
"""Text of each fault, short enough for an alarm that names its place, too."""
_ACTS = {FaultCode.PLATE_TOO_HOT: "Heat is off.", FaultCode.FORCE_SWINGS: "Force is off."}
"""Consequence of a fault of the operator site; all other faults turn the outputs off."""
_PATIENT_ACTS = {
    FaultCode.PATIENT_STOP: "Remote side asks patient, then clears.",
    FaultCode.PATIENT_SWITCH_FAILED: "Remote side mends it.",
}
"""What has to follow the patient's stop, which only the remote site may clear."""
_DEVICES = {EXOSKELETON: "exoskeleton", TELEMANIPULATOR: "remote hand"}
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
    ThermalReason.SENSOR_FROZEN: "sensor ignores heater",
}
_CAMERA = {
    Seen.LATE: ("Picture {age_s:.1f} s late.", "Move slowly."),
    Seen.FROZEN: ("Picture frozen for {age_s:.1f} s.", "Do not rely on it."),
    Seen.NO_CAMERA: ("No camera at the remote site.", "Check its cable."),
    Seen.SILENT: ("No picture for {age_s:.1f} s.", "Start the camera."),
    Seen.REFUSED: ("Camera refuses the key.", "Trust it at the remote site."),
}
"""What is wrong with the picture, and what to do."""
_ABBREVIATED = frozenset(("abs", "ptfe", "pu", "pvc"))
_SURE = 0.995
"""Smallest probability that is shown as above 99 %."""
OBSERVER = "OBSERVER. Control is at {who}."
LINK_LOST = "LINK LOST. Outputs are neutral. Wait for the link."
MOTION_LOST = "MOTION LOST: remote fingers have lifted. Wait, or pause."
LINK_BACK = "Link was lost: session ended. Acknowledge (K)."
FAULT_OVER = "Fault is over. Acknowledge (K)."
STOP_LATE = "Stop was confirmed late. Acknowledge (K)."
DISK_FULL = "Disk full. Recording stopped, findings are kept."
NOT_RECORDED = "Recording stopped. Check the disk, then start again."
REMOTE_NOT_RECORDED = "Remote recording stopped. Check the remote site."
CONSOLE_NOT_RECORDED = "Console's own record stopped. Findings are kept here."
STUDY_NUMBER = "Use a study number, not a name."
ASK_CONSENT = "Ask the patient about the recording, then tick the answer."
TOUCH_NOT_AGREED = "The patient has not agreed to have touch recorded: remove record, then start again."
SAME_CONSENT = "write the same [consent] into the files of both sites"
NOT_SOUNDED = "Cannot engage: sound not checked."
RESTARTED = "Console was restarted. Findings and map are kept."
NOTHING_HERE = "Nothing was felt here."
DISK_FILLS = "Disk {percent:.0f} % full. Make room soon."
SOUND_OFF = "Sound is off. Watch the alarm line."
CAMERA_NEEDED = "Cannot engage: no live picture."
CONSOLE_SLOW = "Console slow. Close other programs."
PLATE_BACK = "{finger}: plate is back. Acknowledge (K)."
NO_REMOTE_SITE = "no remote site is connected"
START_SITE = "No answer. Start it."
NOT_CALIBRATED = "Not calibrated."
NOT_USED = "not used"
NO_SOUND = "off"
NO_REMOTE_DATA = "No data from the remote site."
DISK_USED = "{percent:.0f} % used."
SOUND_NOT_HEARD = "Not heard yet."
PLAY_SOUND = "Play alarm sound, then answer."

STOP_NOT_SENT = "STOP NOT SENT. Use the hardware switch."
FAILED_INSIDE = "That failed inside the console; its log says why."
REQUEST_NOT_RECORDED = "That cannot be recorded. It was not done."
UNKNOWN_REQUEST = "That cannot be asked for here."
CONTROL_ELSEWHERE = "Control is at {who}. Take control first."
NO_SITE = "There is no operator site."
SITE_SILENT = "The operator site does not answer."
FORCE_LIMITED = "Force limited to {limit_n:.1f} N by the patient's threshold."
NOT_KNOWN_YET = "not known yet"
MOVED = "Patient moved by about {by_mm:.0f} mm {way} the hand. Striped: felt before."
TURNED = "Patient turned or moved sideways. Striped: felt before."
ALIKE = ", or all places alike"
TENDER_NOT_HERE = "not the most tender place ({most_tender})"
PAIN_NOT_AGREED = "The patient has not agreed to have pain recorded."
LIMIT_ENDS = "Remote side asks patient, then: teletaction session restore-force."
PAUSED = "PAUSED. Outputs neutral."
MARKS_NEEDED = "Four marks are needed, each on picture and map."
MARKS_KEPT = "Picture registered with the map."
CLUTCH_NEEDED = "Say whether the clutch opens or closes."
CLUTCH_OPEN = "Clutch open. The remote hand stays."
CLUTCH_CLOSED = "Clutch closed."
SCALE_NEEDED = "The motion scale is one of {scales}."
SCALE = "Motion scale {scale}."
NOTHING_TO_CLEAR = "There is nothing to clear."
NOTHING_TO_ACKNOWLEDGE = "No past alarm waits to be acknowledged."
ACKNOWLEDGED = "Acknowledged."
MAY_BE_ENGAGED = "The operator site does not answer. It may be engaged: press STOP."
CLEAR_ASKED = "The remote site is asked to clear its fault."
CLEARED = "Cleared. Nothing moves. Engage again."
CANNOT_ENGAGE = "Cannot engage: {why}"
FAULT_NOT_CLEARED = "Cannot engage: fault not cleared."
PATIENT_STOPS = "Cannot engage: patient's stop. Remote side clears it."
IN_CONTROL = "You are in control."
TOOK_CONTROL = "{who} took control."
NOT_WHILE_ENGAGED = "Not while engaged. Pause first."
SOUND_ANSWER = "Sound is heard or refused."
SOUND_WORKS = "Sound works."
SOUND_PAUSED = "Sound paused {seconds} s."
SOUND_STAYS = "This alarm's sound cannot be paused."
PLACE_NEEDED = "A place has x_mm and y_mm."
SPEED_NEEDED = "play has a speed."
TIME_NEEDED = "seek has a time in s."
PLAYBACK_PAUSED = "Paused."
READING_AHEAD = "A preview. Map and last 10 s follow."

SESSION = "Examination {pseudonym}."
SESSION_OPEN = "Examination {pseudonym} is under way. End it first."
NO_SESSION = "No examination is under way."
BEGIN_FIRST = "Begin an examination first: findings need a study number."
STUDY_NUMBER_LENGTH = "A study number has 1 to {longest} characters."
STUDY_NUMBER_PRINTABLE = "A study number has printable characters only."
FINDING_NEEDS = "A finding has a finger and a kind: {kinds}."
FINDING_NUMBERS = "A finding's time and place are numbers."
FINDING = "Finding {number} {kept}"
NOTE = "Note to finding {number} {kept}"
NOTE_AFTER_END = "The examination has ended, so its report may lack this note."
EDITED = "Change of finding {number} {kept}"
WITHDRAWN = "Withdrawal of finding {number} {kept}"
UNDONE = "Undo for finding {number} {kept}"
WAS_WITHDRAWN = "Finding {number} was withdrawn. Undo that first."
REASON_NEEDED = "A withdrawal needs a reason of 1 to {longest} characters."
CHANGED_SINCE = "Changed since. Look at it, then undo again."
NOTHING_TO_UNDO = "There is nothing to undo."
NO_DIFFERENCE = "no different from its surroundings"
NOT_COMPARED = "{quantity} not compared: too few touches here or around"
ALSO_NOT_COMPARED = "; not compared: {quantities}"
NOTHING_COMPARED = "not compared with its surroundings: too few touches here or around"
BODY_NEEDS = "A place on the body has a region of the picture, and a side: left, right or both."
LANDMARK_LENGTH = "A landmark has {longest} printable characters at most."
LANDMARK_DISTANCE = "A landmark's distance is 0 to {farthest:.0f} mm."
NOT_ON_DISK = "kept here, not yet on disk."
NO_FINDING = "There is no such finding."
NOTE_LENGTH = "A note has {longest} characters at most."
WRITING_REPORT = "The report is being written."
NO_REPORT = "No report: {why}."
NO_REPORT_CONFIGURED = "no report is configured: report_command and reports"
REPORT_LATE = "the report took longer than {seconds:g} s"
REPORT_ENDED = "the command ended with {code}"


def capital(text: str) -> str:
    """Return a text with a capital first letter, such as a device's name that begins a sentence."""
    return text[:1].upper() + text[1:]


def consents_differ(here: Sequence[str] | None, there: Sequence[str] | None, agreed: Sequence[str] | None) -> str:
    """Return how the patient's answers of both sites differ, None for no answer, and what is agreed to by both."""
    counts = f"Counts: {_kinds(agreed)}."
    if here is None or there is None:
        return f"No answer noted {'here' if here is None else 'at the remote site'}. {counts}"
    return f"Patient's answers differ: here {_kinds(here)}; remote {_kinds(there)}. {counts}"


def _kinds(agreed: Sequence[str] | None) -> str:
    return ", ".join(agreed or ()) or "nothing"


def short(text: str) -> str:
    """Return a text cut to the length of an alarm."""
    return text if len(text) <= LONGEST_ALARM else text[: LONGEST_ALARM - 1].rstrip() + "…"


def duration(seconds: float) -> str:
    """Format a duration, such as `12 min 41 s`."""
    whole = max(0, round(seconds))
    return f"{whole // 60} min {whole % 60} s" if whole >= 60 else f"{whole} s"


def count(number: int, of: str) -> str:
    """Format a number of things, such as `3 findings` or `2 touches`."""
    plural = "es" if of.endswith("ch") else "s"
    return f"{number} {of}" + ("" if number == 1 else plural)


def whole(number: float) -> str:
    """Format a number without decimals, such as `−5`; a small one is 0, and never −0."""
    return f"{round(number)}".replace("-", "−")


def percent(probability: float) -> str:
    """Format a probability, never as certain."""
    return "> 99 %" if probability >= _SURE else f"{probability * 100:.0f} %"


def named(material: str) -> str:
    """Return the readable name of a material."""
    return " ".join(word.upper() if word in _ABBREVIATED else word for word in material.split("_"))


def fault(found: Fault) -> str:
    """Return the alarm for a latched fault of the operator site."""
    device = "" if found.where else _DEVICES.get(found.device, "")
    act = "Engage for a plate test." if found.needs_test else _ACTS.get(found.code, "Outputs are off.")
    return _alarm(found, found.where or device, act)


def remote_fault(found: Fault) -> str:
    """Return the alarm for a latched fault of the remote site."""
    if found.code in _PATIENT_ACTS:
        return short(f"{capital(filled(_FAULTS[found.code], found))}. {_PATIENT_ACTS[found.code]}")
    where = found.where or _DEVICES.get(found.device, "site")
    return _alarm(found, f"remote {where}", "It stands still.")


def _alarm(found: Fault, where: str, act: str) -> str:
    """Return place, problem and, if there is room, consequence."""
    what = filled(_FAULTS[found.code], found).rstrip()
    text = short(capital(f"{where}: {what}." if where else f"{what}."))
    whole = f"{text} {act}"
    return whole if len(whole) <= LONGEST_ALARM else text


def plate_over(name: str, plate_c: float) -> str:
    """Return the alarm for a plate above its fault limit, C."""
    return f"{capital(name)}: plate {plate_c:.1f} °C, over {PLATE_FAULT_C:.1f}. Heat is off."


def plate_held(name: str, plate_c: float) -> str:
    """Return the alarm for a plate, C, that is held at its limit."""
    return f"{capital(name)}: plate at {plate_c:.1f} °C, held at its limit. Lift the finger."


def site_slow(rate_hz: object, wanted_hz: object) -> str:
    """Return the alarm for a loop below its rate, Hz; rates that are no numbers are left out."""
    known = isinstance(rate_hz, float) and isinstance(wanted_hz, float)
    rates = f": {rate_hz:.0f} of {wanted_hz:g} ticks a second" if known else ""
    return f"Site slow{rates}. Close other programs."


def link_slow(delay_ms: float, sd_ms: float) -> str:
    """Return the alarm for a link with a delay that a hand notices."""
    return f"Link slow: {delay_ms:.0f} ± {max(1.0, sd_ms):.0f} ms. Move slowly."


def device_lost(name: str) -> str:
    """Return the alarm for a device that was ready before."""
    if name == "exoskeleton":
        return "Exoskeleton lost. No force is felt."
    if name == "remote hand":
        return "Remote hand lost. Nothing is felt."
    return f"{capital(name)} module lost. {capital(name)} feels nothing."


def device_absent(name: str) -> str:
    """Return the text for a device that was never ready."""
    return f"{capital(name)} absent." if name in ("exoskeleton", "remote hand") else f"{capital(name)} module absent."


def bus_trouble(name: str, what: str) -> str:
    """Return the alarm for a CAN controller that reports errors; its device may still work."""
    return short(f"{capital(name)}: CAN bus {what}. Check its cable.")


def camera(seen: Seen, age_s: float, *, pauses: bool) -> str:
    """Return the alarm for a picture that is not live; `pauses` is whether the session pauses for it."""
    what, act = _CAMERA[seen]
    return f"{what.format(age_s=age_s)} {'Session pauses.' if pauses else act}"


def no_data(for_s: float) -> str:
    """Return the alarm for a silent site."""
    return f"No data for {for_s:.1f} s. Screen is not live."


def not_confirmed(devices: Sequence[str]) -> str:
    """Return the alarm for an unconfirmed emergency stop; it names as many devices as fit."""
    for shown in range(len(devices), 0, -1):
        more = f" + {len(devices) - shown}" if shown < len(devices) else ""
        text = f"STOP NOT CONFIRMED: {capital(', '.join(devices[:shown]))}{more}. Use the hardware switch."
        if len(text) <= LONGEST_ALARM or shown == 1:
            return text
    return "STOP NOT CONFIRMED. Use the hardware switch."


def decision(
    status: ThermalStatus, reason: ThermalReason, material: str, summary: TouchSummary, probability: float
) -> tuple[str, str]:
    """Return the state of the identification under a finger, in a word, and its result or reason.

    Args:
        status: status of the identification.
        reason: reason of the status.
        material: the likeliest material.
        summary: touch summary with the candidates.
        probability: probability of the likeliest material.
    """
    best = f"{named(material)} {percent(probability)}" if material else ""
    candidates = [named(name) for name, _ in summary.candidates]
    match status:
        case ThermalStatus.IDENTIFIED:
            return "IDENTIFIED", best
        case ThermalStatus.DECIDING:
            return "DECIDING", best
        case ThermalStatus.AMBIGUOUS:
            return "AMBIGUOUS", " or ".join(candidates[:2]) if len(candidates) > 1 else f"{best} or none calibrated"
        case ThermalStatus.UNKNOWN:
            return "UNKNOWN", _REASONS[reason]
        case ThermalStatus.UNIDENTIFIABLE:
            return "CANNOT IDENTIFY", _REASONS[reason]
        case _:
            return "NO CONTACT", ""


def looks_like_a_name(pseudonym: str) -> bool:
    """Return whether a pseudonym may name a person.

    It may if it has no digit, a date, two words, or a word that is no abbreviation.
    """
    words = re.findall(r"[^\W\d_]{2,}", pseudonym)
    dated = re.search(r"\b\d{1,4}[./-]\d{1,2}[./-]\d{1,4}\b|\b(19|20)\d{6}\b", pseudonym) is not None
    numbered = any(letter.isdigit() for letter in pseudonym)
    return not numbered or dated or len(words) >= 2 or any(len(word) > 2 and not word.isupper() for word in words)


def cut_off(pseudonym: str, findings: int, files: Sequence[str]) -> str:
    """Return the summary of an examination that a restart of the machine has ended."""
    return f"Examination {pseudonym} was cut off: {count(findings, 'finding')} kept in {', '.join(files)}."


def ended(
    seconds: float,
    findings: int,
    lost: int,
    *,
    recorded: bool = True,
    unsaved: int = 0,
    placeless: int = 0,
    withdrawn: int = 0,
) -> str:
    """Return the summary of an examination that ended: duration, findings, messages that the recording lost."""
    text = f"{duration(seconds)}, {count(findings, 'finding')}{f' ({withdrawn} withdrawn)' if withdrawn else ''}"
    text = f"Saved: {text}, {count(lost, 'message')} lost." if recorded else f"Not recorded: {text}."
    if unsaved:
        text = f"{count(unsaved, 'finding')} not yet on disk."
    return f"{text} Report has {count(placeless, 'finding')} without a place." if placeless else text


def place(value: str, touches: int, ago_s: float, contrast: str) -> str:
    """Return a value at a place, its contrast if known, its number of touches and the time since the last one, s."""
    return f"{value}{contrast and f', {contrast}'}, {count(touches, 'touch')}, {ago_s:.0f} s ago"


def moved(by_m: float | None) -> str:
    """Return that the patient has moved along the normal, m, positive towards the hand; None for another way."""
    if by_m is None:
        return TURNED
    return MOVED.format(by_mm=1e3 * abs(by_m), way="towards" if by_m > 0.0 else "away from")


def most_tender(place_mm: tuple[float, float, float] | None, threshold_n: float | None, *, alike: bool = False) -> str:
    """Return the most tender place, its standard deviation, mm, and the force at which pain begins there, N.

    `alike` is whether all places may be equally tender.
    """
    where = NOT_KNOWN_YET
    if place_mm is not None:
        x, y, _ = map(whole, place_mm)
        where = f"near x {x} y {y} mm, ± {max(1.0, place_mm[2]):.0f} mm{ALIKE if alike else ''}"
    return f"most tender {where}; pain from {NOT_KNOWN_YET if threshold_n is None else f'about {threshold_n:.1f} N'}"


def tenderness(
    place_mm: tuple[float, float, float] | None,
    threshold_n: float | None,
    reaction_s: float | None,
    *,
    alike: bool = False,
) -> str:
    """Return the most tender place, see `most_tender`, and the patient's reaction time, s."""
    reaction = NOT_KNOWN_YET if reaction_s is None else f"about {reaction_s:.1f} s"
    return f"{capital(most_tender(place_mm, threshold_n, alike=alike))}; reaction {reaction}."


def with_lump(stiffness: str, probability: float) -> str:
    """Return a stiffness with the probability that its place belongs to a lump."""
    return f"{stiffness}, lump {percent(probability)}"
