"""Samples the resources and the status of a session's processes once a second, as JSON lines.

    python -m robustness.soak_watch FOLDER

It runs in a process of its own, because the soak sleeps during its faults and must not start processes beside a thread.
"""

import json
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from teletaction.session.demo_files import NETWORK, PROCESSES
from teletaction.session.processes import die_with_parent, family

EVERY_S = 1.0
WATCHED = (*PROCESSES, NETWORK)
_KIB_PER_MIB = 1024.0
_OF_DEVICES = ("fault", "missing", "limited", "texture_faults", "devices")
_KEPT = ("state", *_OF_DEVICES, "delay_ms", "recording_lost", "recording_failed")


@dataclass(frozen=True, slots=True)
class Sample:
    """One look at one process.

    Attributes:
        time_s: time on the monotonic clock.
        pid: process number, which distinguishes a restarted process from the one before.
        rss_mib, open_files, threads: values from /proc, including the processes that it started.
        status: parts of its status file on state, devices, loop and injected faults.
    """

    time_s: float
    process: str
    pid: int
    rss_mib: float
    open_files: int
    threads: int
    status: dict[str, Any]


@contextmanager
def watching(folder: Path, log: Path) -> Iterator[None]:
    """Write samples of the processes with status files in `folder` to `log` until the context ends."""
    with log.open("wb") as out:
        watch = subprocess.Popen(
            [sys.executable, "-m", "robustness.soak_watch", str(folder)],
            stdout=out,
            stdin=subprocess.DEVNULL,
            preexec_fn=die_with_parent,  # noqa: PLW1509 - the soak has no other thread
        )
        try:
            yield
        finally:
            watch.terminate()
            watch.wait()


def read_samples(log: Path) -> list[Sample]:
    """Return all samples of a log in order of time; an incomplete last line is left out."""
    whole, _, _ = log.read_text("utf-8").rpartition("\n")
    return [Sample(**json.loads(line)) for line in whole.splitlines()]


def sample(folder: Path, process: str) -> Sample | None:
    """Look at a process; return None while it has no status or after it has ended."""
    try:
        status = json.loads((folder / f"{process}.json").read_text("utf-8"))
        looks = [_look(pid) for pid in family(status["pid"])]
    except (OSError, ValueError, KeyError):  # not yet started, just killed, or ending and without memory
        return None
    kept = {name: status[name] for name in _KEPT if name in status}
    if "overruns" in status["loop"]:
        kept["overruns"] = status["loop"]["overruns"]
    if process == NETWORK:
        kept["faults"] = Counter(fault["kind"] for fault in status["faults"])
    rss_mib, open_files, threads = (sum(figures) for figures in zip(*looks, strict=True))
    return Sample(time.monotonic(), process, status["pid"], round(rss_mib, 2), int(open_files), int(threads), kept)


def _look(pid: int) -> tuple[float, int, int]:
    """Return memory, MiB, and the numbers of open files and threads."""
    proc = Path("/proc") / str(pid)
    status = dict(line.split(":\t", 1) for line in (proc / "status").read_text("ascii").splitlines())
    return int(status["VmRSS"].split()[0]) / _KIB_PER_MIB, len(os.listdir(proc / "fd")), int(status["Threads"])


def main(folder: Path) -> None:
    """Print a sample of every process once a second, until the process is ended."""
    while True:
        for process in WATCHED:
            found = sample(folder, process)
            if found is not None:
                print(json.dumps({name: getattr(found, name) for name in Sample.__slots__}))
        sys.stdout.flush()
        time.sleep(EVERY_S)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
