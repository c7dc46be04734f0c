"""Measures the speed of this machine's processors and how many of them are idle."""

import time
from dataclasses import dataclass
from pathlib import Path

from common.runtime.parallel_map import processors
from common.runtime.reference_step import reference_step_s

LOOK_S = 0.3
"""Duration of the measurement of idle processors, s."""


@dataclass(frozen=True, slots=True)
class ProcessorTime:
    """Time of all processors since the machine started, in ticks of the system's clock.

    Attributes:
        idle: idle time.
        stolen: time in which other virtual machines ran.
        total: sum of all times.
    """

    idle: int
    stolen: int
    total: int

    @classmethod
    def now(cls) -> "ProcessorTime":
        """Read the system's counters; raises OSError where there is no /proc/stat."""
        first = Path("/proc/stat").read_text("ascii").partition("\n")[0]
        user, nice, system, idle, waiting, irq, softirq, stolen = map(int, first.split()[1:9])
        return cls(idle + waiting, stolen, user + nice + system + idle + waiting + irq + softirq + stolen)

    def shares(self, before: "ProcessorTime") -> dict[str, float]:
        """Return the idle and stolen shares since `before`, 0..1."""
        total = max(1, self.total - before.total)
        return {
            "idle": round((self.idle - before.idle) / total, 4),
            "stolen": round((self.stolen - before.stolen) / total, 4),
        }


@dataclass(frozen=True, slots=True)
class Machine:
    """Computing power that a session may use.

    Attributes:
        step_s: processor time of a reference step, s.
        idle: number of idle processors, 0 to all of them.
    """

    step_s: float
    idle: float

    @classmethod
    def measured(cls) -> "Machine":
        """Measure for LOOK_S; raises OSError where the system does not count idle time."""
        before = ProcessorTime.now()
        time.sleep(LOOK_S)
        idle = ProcessorTime.now().shares(before)["idle"]
        return cls(reference_step_s(), idle * processors())
