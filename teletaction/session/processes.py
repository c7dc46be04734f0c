"""The processes of a session on this machine: started together, watched, ended together."""

import ctypes
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from common.files.printable import printable
from common.logs import spoken

KILLED_S = 10.0
"""A process that has not ended by itself this long after it was asked to is killed, s. On a machine with time for it,
it takes less than 2 s."""
_PR_SET_PDEATHSIG = 1
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def die_with_parent() -> None:
    """In a child process: end when the launcher is gone, however it went, and leave Ctrl-C to the launcher alone."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
    os.setsid()


@dataclass(slots=True)
class SessionProcesses:
    """Processes by name, each with a log file of its own in `out`."""

    out: Path
    running: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)
    _given: dict[str, tuple[Path, tuple[str, ...]]] = field(default_factory=dict)

    def start(self, name: str, config: Path, *options: str) -> None:
        """Start one process with its configuration file, and what else its command is to be told."""
        again = name in self._given
        self._given[name] = config, options
        with (self.out / f"{name}.log").open("ab" if again else "wb") as log:
            self.running[name] = subprocess.Popen(
                [sys.executable, "-m", "teletaction", name, "--config", str(config), *options],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                preexec_fn=die_with_parent,  # noqa: PLW1509 - no other thread of the launcher runs Python
            )

    def restart(self, name: str) -> None:
        """Start a process that has ended once more, as before; its log goes on."""
        config, options = self._given[name]
        self.start(name, config, *options)

    def ended(self) -> dict[str, int]:
        """Exit codes of those that are no longer running."""
        return {name: code for name, process in self.running.items() if (code := process.poll()) is not None}

    def last_words(self, name: str) -> str:
        """What the last line of a process's log says."""
        lines = (self.out / f"{name}.log").read_text("utf-8", errors="replace").strip().splitlines()
        return printable(spoken(lines[-1])) if lines else "it said nothing"

    def end(self) -> list[str]:
        """End all within KILLED_S, the operator first; names of those that had to be killed."""
        deadline_s = time.monotonic() + KILLED_S
        for name in reversed(self.running):
            if self.running[name].poll() is None:
                self.running[name].send_signal(signal.SIGTERM)
        killed = []
        for name, process in self.running.items():
            try:
                process.wait(max(0.0, deadline_s - time.monotonic()))
            except subprocess.TimeoutExpired:
                killed.append(name)
                process.kill()
                process.wait()
        return killed

    def usage(self) -> dict[str, tuple[float, float]]:
        """CPU time used so far (s) and largest resident memory (MiB) of each running process and those it started."""
        found = {}
        for name, process in self.running.items():
            used = [one for pid in family(process.pid) if (one := _used(pid)) is not None]
            if used:
                found[name] = (sum(cpu_s for cpu_s, _ in used), sum(peak_mib for _, peak_mib in used))
        return found


def family(pid: int) -> list[int]:
    """A process and those that it started, a recording's writer above all, as far as they run."""
    started = [int(child) for file in Path(f"/proc/{pid}/task").glob("*/children") for child in _read(file).split()]
    return [pid, *(member for child in started for member in family(child))]


def _used(pid: int) -> tuple[float, float] | None:
    """CPU time (s), with that of what it started and saw end, and largest memory (MiB); None for one that is gone."""
    stat, status = _read(Path(f"/proc/{pid}/stat")), _read(Path(f"/proc/{pid}/status"))
    if not stat:
        return None
    ticks = sum(int(number) for number in stat.rsplit(")", 1)[1].split()[11:15])
    peak = next((line.split()[1] for line in status.splitlines() if line.startswith("VmHWM")), "0")
    return ticks / _TICKS_PER_S, int(peak) / 1024.0


def _read(file: Path) -> str:
    """What the system tells of a process; nothing, if that is gone."""
    try:
        return file.read_text("ascii")
    except (FileNotFoundError, ProcessLookupError):
        return ""
