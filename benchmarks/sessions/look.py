"""Looks at running sessions from outside, by their status files and /proc."""

import os
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robustness.fault_session import read_figures
from teletaction.session.processes import SessionProcesses, family

_HZ = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True, slots=True)
class Look:
    """One look at a process.

    Attributes:
        at_s: time of the look on the monotonic clock, s.
        status: content of its status file.
        worked_s: processor time of all its threads, and of the process that writes its recording, s.
        loop_worked_s: processor time of its loop's thread, s.
        loop_waited_s: time for which its loop's thread waited for a processor, s.
        memory_mib: proportional set size of the process and of the process that writes its recording, MiB.
    """

    at_s: float
    status: dict[str, Any]
    worked_s: float
    loop_worked_s: float
    loop_waited_s: float
    memory_mib: float

    @property
    def status_s(self) -> float:
        """Time at which its status file was written, s."""
        return float(self.status["time_ns"]) * 1e-9

    def since(self, before: "Look") -> dict[str, Any]:
        """Return rate, work and waiting since an earlier look; `said` is what the process reports of its rate."""
        looked_s, status_s = self.at_s - before.at_s, max(1e-9, self.status_s - before.status_s)
        loop, behind_s = self.status["loop"], self.status["behind_s"] - before.status["behind_s"]
        wanted_hz = 1e3 / loop["period_ms"]
        rate_hz = (loop["ticks"] - before.status["loop"]["ticks"]) / status_s
        return {
            "wanted_hz": wanted_hz,
            "rate_hz": round(rate_hz, 1),
            "made": round(min(1.0, rate_hz / wanted_hz), 4),
            "core": round((self.worked_s - before.worked_s) / looked_s, 4),
            "loop_works": round((self.loop_worked_s - before.loop_worked_s) / looked_s, 4),
            "loop_waits": round((self.loop_waited_s - before.loop_waited_s) / looked_s, 4),
            "memory_mib": round(self.memory_mib, 1),
            "said": self.status["behind"] or (f"behind for {behind_s:.0f} s" if behind_s > 0.0 else ""),
        }

    def packets(self, before: "Look", stream: str, counters: Iterable[str]) -> dict[str, float]:
        """Return packets per second, by counter, since an earlier look."""
        status_s = max(1e-9, self.status_s - before.status_s)
        return {
            f"{name}_hz": round((_count(self.status, name, stream) - _count(before.status, name, stream)) / status_s, 1)
            for name in counters
        }


def look(pair: SessionProcesses) -> dict[str, Look]:
    """Look at each process of a session that runs and has written its status."""
    found = {}
    for name, process in pair.running.items():
        status = read_figures(pair.out, name)
        try:
            if "behind" in status:
                found[name] = _look(process.pid, status)
        except (FileNotFoundError, ProcessLookupError, StopIteration):
            continue  # it has just ended
    return found


def _look(pid: int, status: dict[str, Any]) -> Look:
    process = Path(f"/proc/{pid}")
    members = [Path(f"/proc/{member}") for member in family(pid)]
    # The loop runs in the first thread, and this file counts that thread.
    waited_ns = int((process / "schedstat").read_bytes().split()[1])
    return Look(
        time.monotonic(),
        status,
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


def _count(status: dict[str, Any], counter: str, stream: str) -> int:
    value = status[counter].get(stream, 0)
    return sum(value.values()) if isinstance(value, dict) else int(value)
