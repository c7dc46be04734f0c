"""What is seen of running sessions from outside: status files and /proc."""

import os
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from studies.fault_session import read_figures
from teletaction.processes import SessionProcesses, family

_HZ = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True, slots=True)
class Look:
    """One look at a process.

    Attributes:
        at_s: when, monotonic clock.
        told: its status file.
        worked_s: processor time of all its threads, and of the process that writes its recording, s.
        loop_worked_s, loop_waited_s: of its loop's thread: processor time, and for how long it waited for a processor.
        memory_mib: what both hold alone, and their part of what they share with others.
    """

    at_s: float
    told: dict[str, Any]
    worked_s: float
    loop_worked_s: float
    loop_waited_s: float
    memory_mib: float

    @property
    def told_s(self) -> float:
        """When its status file was written, s."""
        return float(self.told["time_ns"]) * 1e-9

    def since(self, before: "Look") -> dict[str, Any]:
        """Rate, work and waiting since an earlier look; `said` is what the process itself says of its rate."""
        looked_s, told_s = self.at_s - before.at_s, max(1e-9, self.told_s - before.told_s)
        loop, behind_s = self.told["loop"], self.told["behind_s"] - before.told["behind_s"]
        wanted_hz = 1e3 / loop["period_ms"]
        rate_hz = (loop["ticks"] - before.told["loop"]["ticks"]) / told_s
        return {
            "wanted_hz": wanted_hz,
            "rate_hz": round(rate_hz, 1),
            "made": round(min(1.0, rate_hz / wanted_hz), 4),
            "core": round((self.worked_s - before.worked_s) / looked_s, 4),
            "loop_works": round((self.loop_worked_s - before.loop_worked_s) / looked_s, 4),
            "loop_waits": round((self.loop_waited_s - before.loop_waited_s) / looked_s, 4),
            "memory_mib": round(self.memory_mib, 1),
            "said": self.told["behind"] or (f"behind for {behind_s:.0f} s" if behind_s > 0.0 else ""),
        }

    def packets(self, before: "Look", stream: str, counters: Iterable[str]) -> dict[str, float]:
        """Packets a second, by counter, since an earlier look."""
        told_s = max(1e-9, self.told_s - before.told_s)
        return {
            f"{name}_hz": round((_count(self.told, name, stream) - _count(before.told, name, stream)) / told_s, 1)
            for name in counters
        }


def look(pair: SessionProcesses) -> dict[str, Look]:
    """One look at each process of a session that is there and has told how it is."""
    found = {}
    for name, process in pair.running.items():
        told = read_figures(pair.out, name)
        try:
            if "behind" in told:
                found[name] = _look(process.pid, told)
        except (FileNotFoundError, ProcessLookupError, StopIteration):
            continue  # it has just ended
    return found


def _look(pid: int, told: dict[str, Any]) -> Look:
    process = Path(f"/proc/{pid}")
    members = [Path(f"/proc/{member}") for member in family(pid)]
    # Its loop runs in its first thread, whose numbers these are.
    waited_ns = int((process / "schedstat").read_bytes().split()[1])
    return Look(
        time.monotonic(),
        told,
        sum(_worked_s(member / "stat") for member in members),
        _worked_s(process / "task" / str(pid) / "stat"),
        waited_ns * 1e-9,
        sum(_memory_mib(member) for member in members),
    )


def _worked_s(stat: Path) -> float:
    fields = stat.read_text("ascii").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / _HZ


def _memory_mib(process: Path) -> float:
    lines = (process / "smaps_rollup").read_text("ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("Pss:")) / 1024.0


def _count(told: dict[str, Any], counter: str, stream: str) -> int:
    value = told[counter].get(stream, 0)
    return sum(value.values()) if isinstance(value, dict) else int(value)
