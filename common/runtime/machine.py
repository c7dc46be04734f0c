"""How fast the processors of this machine are, and how many of them are idle."""

import time
from dataclasses import dataclass
from pathlib import Path

from common.runtime.parallel_map import processors
from common.runtime.reference_step import reference_step_s

LOOK_S = 0.3
"""How long idle processors are counted."""


@dataclass(frozen=True, slots=True)
class ProcessorTime:
    """Time of all processors of the machine since it started, in ticks of the system's clock.

    Attributes:
        idle: in which nothing ran.
        stolen: in which other virtual machines ran.
        total: all of it.
    """

    idle: int
    stolen: int
    total: int

    @classmethod
    def now(cls) -> "ProcessorTime":
        """As the system counts it; raises OSError where there is no /proc/stat."""
        first = Path("/proc/stat").read_text("ascii").partition("\n")[0]
        user, nice, system, idle, waiting, irq, softirq, stolen = map(int, first.split()[1:9])
        return cls(idle + waiting, stolen, user + nice + system + idle + waiting + irq + softirq + stolen)

    def shares(self, before: "ProcessorTime") -> dict[str, float]:
        """Idle and stolen shares since an earlier look, 0..1."""
        total = max(1, self.total - before.total)
        return {
            "idle": round((self.idle - before.idle) / total, 4),
            "stolen": round((self.stolen - before.stolen) / total, 4),
        }


@dataclass(frozen=True, slots=True)
class Machine:
    """What a session may use.

    Attributes:
        step_s: processor time of a reference step, s.
        idle: processors that nothing else uses, 0 to their number.
    """

    step_s: float
    idle: float

    @classmethod
    def measured(cls) -> "Machine":
        """Measure for LOOK_S; raises OSError where idle time is not counted."""
        before = ProcessorTime.now()
        time.sleep(LOOK_S)
        idle = ProcessorTime.now().shares(before)["idle"]
        return cls(reference_step_s(), idle * processors())
