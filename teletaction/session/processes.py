"""Starts, watches and ends the processes of a session on this machine."""

import ctypes
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from common.files.printable import printable
from common.files.private_file import create_private
from common.logs import spoken

KILLED_S = 10.0
"""Time from the request to end after which a process is killed, s. Without other load a process ends within 2 s."""
_PR_SET_PDEATHSIG = 1
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def die_with_parent() -> None:
    """Make this child process end with the launcher in all cases, and leave Ctrl-C to the launcher."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
    os.setsid()


@dataclass(slots=True)
class SessionProcesses:
    """Processes by name, each with its own log file in `out`."""

    out: Path
    running: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)
    _given: dict[str, tuple[Path, tuple[str, ...]]] = field(default_factory=dict)

    def start(self, name: str, config: Path, *options: str) -> None:
        """Start one process with its configuration file and further command-line options."""
        again = name in self._given
        self._given[name] = config, options
        path = self.out / f"{name}.log"
        with path.open("ab") if again else create_private(path, replace=True) as log:
            self.running[name] = subprocess.Popen(
                [sys.executable, "-m", "teletaction", name, "--config", str(config), *options],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                preexec_fn=die_with_parent,  # noqa: PLW1509 - no other thread of the launcher runs Python
            )

    def restart(self, name: str) -> None:
        """Restart a process that has ended, with the same options; its log is continued."""
        config, options = self._given[name]
        self.start(name, config, *options)

    def ended(self) -> dict[str, int]:
        """Return the exit codes of processes that have ended."""
        return {name: code for name, process in self.running.items() if (code := process.poll()) is not None}

    def last_words(self, name: str) -> str:
        """Return the text of the last line of a process's log."""
        lines = (self.out / f"{name}.log").read_text("utf-8", errors="replace").strip().splitlines()
        return printable(spoken(lines[-1])) if lines else "its log is empty"

    def end(self) -> list[str]:
        """End all processes within KILLED_S, in reverse order of their start; return the names of those killed."""
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
        """Return CPU time so far (s) and peak resident memory (MiB) of each running process with its children."""
        found = {}
        for name, process in self.running.items():
            used = [one for pid in family(process.pid) if (one := _used(pid)) is not None]
            if used:
                found[name] = (sum(cpu_s for cpu_s, _ in used), sum(peak_mib for _, peak_mib in used))
        return found


def family(pid: int) -> list[int]:
    """Return the ids of a process and its running descendants, such as the writer of its recording."""
    started = [int(child) for file in Path(f"/proc/{pid}/task").glob("*/children") for child in _read(file).split()]
    return [pid, *(member for child in started for member in family(child))]


def _used(pid: int) -> tuple[float, float] | None:
    """Return CPU time (s) with that of reaped children, and peak memory (MiB); None for an ended process."""
    stat, status = _read(Path(f"/proc/{pid}/stat")), _read(Path(f"/proc/{pid}/status"))
    if not stat:
        return None
    ticks = sum(int(number) for number in stat.rsplit(")", 1)[1].split()[11:15])
    peak = next((line.split()[1] for line in status.splitlines() if line.startswith("VmHWM")), "0")
    return ticks / _TICKS_PER_S, int(peak) / 1024.0


def _read(file: Path) -> str:
    """Read a file of /proc; return an empty string if the process has ended."""
    try:
        return file.read_text("ascii")
    except (FileNotFoundError, ProcessLookupError):
        return ""
