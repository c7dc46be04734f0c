"""Renders the findings of the fault matrix, as a page and as data."""

from collections.abc import Sequence
from typing import Any

from common.limits import LIFT_OFF_S, PATIENT_STOP_S
from robustness.fault_judge import HOLD_S, Finding
from robustness.fault_table import Actuator

_REAL = "All sites and simulators are processes of their own, in real time."
_ON_BED = """Faults that need real processes, a real disk or TCP connections are injected into real processes. All
others are injected on the test bed: both sites, their real drivers, the link and all devices in one process on a
virtual clock, where each tick is on time on any machine. `FAULTS=real make faults` uses real processes for all."""
HEAD = """# Faults

The required and the measured effect of each fault on both sites, a simulated network between them, and simulated
devices that fail on command. `make faults` injects all of them again, judges them, and writes this page.
{form}

- *continues*: the finger keeps feeling force, and at most what depends on the failed part is neutral.
- *safe and resumes*: everything is neutral within the hold times, and works again by itself when the fault is over,
  ramping from zero.
- *latched*: everything is neutral until a person clears the fault and engages again.

Times are measured at the simulated actuators, every 10 ms. They count from the fault. For a silent device they count
from when a site can know of it (100 ms), and for a fault that is detected by its effect, from the latch. After the
patient's stop, *contact force falls* and *off* count from the press (allowed: {falls:.0f} and {off:.0f} ms). Other work
on the machine may pause a process. The table shows the longest such pause during each fault, and a time may exceed its
limit by this pause and 20 ms. *Works again* counts from the end of the fault, or from engaging again, to force and
vibration at the finger.

"""


def table(findings: Sequence[Finding]) -> str:
    """The findings as a Markdown table."""
    limits = " · ".join(f"{actuator.value} {HOLD_S[actuator] * 1e3:.0f}" for actuator in Actuator)
    lines = [
        f"| fault | outcome | latched after, s | neutral after, ms (allowed: {limits}) | works again after, s | "
        "machine's pause, ms | |",
        "|---|---|---|---|---|---|---|",
    ]
    for finding in findings:
        times_s = {actuator.value: s for actuator, s in finding.safe_s.items()}
        times_s |= {f"contact force {name}": s for name, s in finding.leaves_s.items()}
        safe = ", ".join(f"{name} {s * 1e3:.0f}" for name, s in times_s.items())
        lines.append(
            f"| {finding.fault.name} | {finding.fault.expected.value} | {_number(finding.latched_s)} | {safe or '-'} | "
            f"{_number(finding.resumed_s)} | {finding.paused_s * 1e3:.0f} | "
            f"{'; '.join(finding.wrong) or finding.latched_by} |"
        )
    return "\n".join(lines) + "\n"


def as_data(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """The findings as data for JSON."""
    return [
        {
            "fault": finding.fault.name,
            "expected": finding.fault.expected.value,
            "outcome": None if finding.outcome is None else finding.outcome.value,
            "safe_s": {actuator.value: round(s, 3) for actuator, s in finding.safe_s.items()},
            "leaves_s": {name: round(s, 3) for name, s in finding.leaves_s.items()},
            "paused_s": round(finding.paused_s, 3),
            "latched_s": finding.latched_s,
            "latched_by": finding.latched_by,
            "resumed_s": finding.resumed_s,
            "wrong": finding.wrong,
        }
        for finding in findings
    ]


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


TAIL = """
Faults that take too long in real time, or that no process can be given, are tested on a virtual clock
(`tests/virtual`). Both real sites, drivers, device emulators and physics run in one process, judged at every tick:

| fault | outcome |
|---|---|
| partition of 60 s, of 600 s | safe and resumes |
| delay of 200 ms, of 400 ms, age limit 150 ms | safe, and resumes when the delay falls |
| delay of 400 ms, age limit 500 ms at both sites | continues |
| stall of 3 s, then a burst | safe and resumes; no packet of the burst that is too old is acted on |
| packets doubled, overtaking each other, old, of an earlier session | continues; each is counted |
| clock of either site stepped by 10 s, forward or back | safe and resumes |
| a TactTip's cooling water lost for good while it cools its plate | latched within 20 s, by the hot side that moves |
| a TactTip's thermistor comes off within 5 to 70 s while 38.0 or 39.9 °C is displayed | latched; plate at most 43 °C |
| a TactTip's thermistor broken, or its Peltiers reversed, from nine states | latched; plate and skin within limits |
| a telemanipulator that ignores its release | latched within 0.5 s of the release |
| a CAN node that receives no commands for a while | safe and resumes: force from zero, fingers lowered at 20 mm/s |
| a bad TactTip's faults, cleared for 10 min | latched twice; then that plate alone is off until mended |
| a thermal sensor frozen or reversed for 10 min | its heater alone is off until mended |
| a thermal sensor loose before the session | its heater gets at most 1.5 s of strong drive in 30 s |
| anything of this page at random, several at once | within the hold times; nothing while latched; works at the end |

A remote site that is killed while a person's stop is latched is latched again when it is started
(`tests/system/test_stop_survives.py`).
"""


def page(findings: Sequence[Finding], real: bool) -> str:
    """The whole page as Markdown.

    Args:
        findings: of every fault.
        real: whether all faults were injected into real processes.
    """
    head = HEAD.format(form=_REAL if real else _ON_BED, falls=PATIENT_STOP_S * 1e3, off=LIFT_OFF_S * 1e3)
    return head + table(findings) + TAIL
