"""What the fault matrix found, as a page and as data."""

from collections.abc import Sequence
from typing import Any

from studies.fault_judge import HOLD_S, Finding
from studies.fault_table import Actuator

_REAL = "All sites and simulators are processes of their own, in real time."
_ON_BED = """Faults that need real processes, a real disk or TCP connections are done to real processes. All others
are done on the test bed: both sites, their real drivers, the link and all devices in one process on a virtual clock,
where each tick is on time on any machine (`FAULTS=real make faults` does these to real processes, too)."""
HEAD = """# Faults

What has to come of each fault, and what came of it: both sites, a simulated network between them, and simulated
devices that fail on command. `make faults` does all of them anew, judges them, and writes this page.
{form}

- *continues*: the finger goes on feeling force, and at most what depends on the failed part is neutral.
- *safe and resumes*: everything is neutral within the hold times, and works again by itself when the fault is over,
  ramping from zero.
- *latched*: everything is neutral until a person clears the fault and engages again.

Times are measured at the simulated actuators, every 10 ms. They count from the fault; where a device has fallen silent,
from when a site can know it (100 ms); where a fault is found by what it does, from the latch. On a machine that others
use as well a process may be kept from working: the longest such pause during a fault is in the table, and a time may be
longer by it and by 20 ms, no more. *Works again* counts from the end of the fault, or from engaging anew, to force and
vibration at the finger.

"""


def table(findings: Sequence[Finding]) -> str:
    """The measured table as Markdown."""
    limits = " · ".join(f"{actuator.value} {HOLD_S[actuator] * 1e3:.0f}" for actuator in Actuator)
    lines = [
        f"| fault | outcome | latched after, s | neutral after, ms (allowed: {limits}) | works again after, s | "
        "machine's pause, ms | |",
        "|---|---|---|---|---|---|---|",
    ]
    for finding in findings:
        safe = ", ".join(f"{actuator.value} {s * 1e3:.0f}" for actuator, s in finding.safe_s.items())
        lines.append(
            f"| {finding.fault.name} | {finding.fault.expected.value} | {_number(finding.latched_s)} | {safe or '-'} | "
            f"{_number(finding.resumed_s)} | {finding.paused_s * 1e3:.0f} | "
            f"{'; '.join(finding.wrong) or finding.latched_by} |"
        )
    return "\n".join(lines) + "\n"


def as_data(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """The same for programs."""
    return [
        {
            "fault": finding.fault.name,
            "expected": finding.fault.expected.value,
            "outcome": None if finding.outcome is None else finding.outcome.value,
            "safe_s": {actuator.value: round(s, 3) for actuator, s in finding.safe_s.items()},
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
What takes too long in real time, or cannot be done to a process, is tried with both real sites, drivers, device
emulators and physics in one process on a virtual clock (`tests/virtual`), judged at every tick:

| fault | outcome |
|---|---|
| partition of 60 s, of 600 s | safe and resumes |
| delay of 200 ms, of 400 ms, age limit 150 ms | safe, and resumes when the delay falls |
| delay of 400 ms, age limit 500 ms at both sites | continues |
| stall of 3 s, then a burst | safe and resumes; nothing of the burst that is too old is acted on |
| packets doubled, overtaking each other, old, of an earlier session | continues; each is counted |
| clock of either site stepped by 10 s, forward or back | safe and resumes |
| a TactTip's cooling water lost for good while it cools its plate | latched within 20 s, by the hot side that moves |
| a TactTip's thermistor broken, or its Peltiers reversed, from nine states | latched; plate and skin within limits |
| a telemanipulator that ignores its release | latched within 0.5 s of the release |
| a bad TactTip's faults, cleared for 10 min | latched twice; then that plate alone is off until mended |
| a thermal sensor frozen or reversed for 10 min | its heater alone is off until mended |
| anything of this page at random, several at once | within the hold times; nothing while latched; works at the end |
"""


def page(findings: Sequence[Finding], real: bool) -> str:
    """The table with what it means.

    Args:
        findings: of every fault.
        real: whether all were done to real processes.
    """
    return HEAD.format(form=_REAL if real else _ON_BED) + table(findings) + TAIL
