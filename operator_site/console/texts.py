"""Every word that the console says: where, what with value and limit, what to do; at most 60 characters in an alarm."""

import re
from collections.abc import Sequence

from common.limits import PLATE_FAULT_C
from common.wire.messages import ThermalStatus
from common.wire.touch_summary import TouchSummary

LONGEST_ALARM = 60
_PLATE_OVER = re.compile(r"(\w+): plate at ([\d.]+) C, above")
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


def fault(text: str) -> str:
    """A latched fault of the operator's site."""
    if (over := _PLATE_OVER.match(text)) is not None:
        return f"{finger(over[1])}: plate {over[2]} °C, over {PLATE_FAULT_C:.1f}. Heat is off."
    where, _, what = text.partition(": ")
    if what and any(word in what for word in ("swing", "force", "energy")):
        return short(f"{finger(where)}: force not following. Force is off.")
    if what:
        return short(f"{finger(where.replace(' tacttip', ''))}: {what}. Outputs are off.")
    return short(f"{finger(text)}. Outputs are neutral.")


def remote_fault(text: str) -> str:
    """A latched fault of the remote site."""
    return short(f"Remote site: {text}. It stands still.")


def plate_over(name: str, plate_c: float) -> str:
    """A plate beyond what may ever be."""
    return f"{finger(name)}: plate {plate_c:.1f} °C, over {PLATE_FAULT_C:.1f}. Heat is off."


def plate_held(name: str, limit_c: float) -> str:
    """A plate that is kept at its limit."""
    return f"{finger(name)}: plate held at {limit_c:.1f} °C limit. Lift the finger."


def site_slow(behind: str) -> str:
    """A loop that does not hold its rate, by what its site says of it: `442 of 500 ticks a second; ...`."""
    return f"Site slow: {behind.partition(';')[0]}. Close other programs."


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


def decision(status: ThermalStatus, material: str, told: TouchSummary, probability: float) -> tuple[str, str]:
    """What is known of the object under a finger: a word, and a line.

    Args:
        status: of the identification.
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
            return "UNKNOWN", "UNKNOWN: matches nothing calibrated"
        case ThermalStatus.UNIDENTIFIABLE:
            return "CANNOT TELL", "CANNOT TELL"  # there are many reasons, and touch packets name none
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
