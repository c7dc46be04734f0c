"""`python -m studies.soak_watch FOLDER`: what the processes of a session use and tell, once a second, as JSON lines.

A process of its own: the soak itself sleeps through its faults, and must not start processes beside a thread.
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

from teletaction.demo_files import NETWORK, PROCESSES
from teletaction.processes import die_with_parent, family

EVERY_S = 1.0
WATCHED = (*PROCESSES, NETWORK)
_KIB_PER_MIB = 1024.0
_OF_DEVICES = ("fault", "missing", "limited", "texture_faults", "devices")
_TOLD = ("state", *_OF_DEVICES, "delay_ms", "recording_lost", "recording_failed")


@dataclass(frozen=True, slots=True)
class Sample:
    """One look at one process.

    Attributes:
        time_s: monotonic clock.
        pid: tells a restarted process from the one before.
        rss_mib, open_files, threads: from /proc, with those of the processes that it started.
        told: what its status file says of its state, its devices, its loop, the faults it did.
    """

    time_s: float
    process: str
    pid: int
    rss_mib: float
    open_files: int
    threads: int
    told: dict[str, Any]


@contextmanager
def watching(folder: Path, log: Path) -> Iterator[None]:
    """Write samples of the processes with status files in `folder` to `log`, until left."""
    with log.open("wb") as out:
        watch = subprocess.Popen(
            [sys.executable, "-m", "studies.soak_watch", str(folder)],
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
    """All samples of a log in order of time; the line that was being written at its end is left out."""
    whole, _, _ = log.read_text("utf-8").rpartition("\n")
    return [Sample(**json.loads(line)) for line in whole.splitlines()]


def sample(folder: Path, process: str) -> Sample | None:
    """One look at a process; None while it has told nothing, or is gone."""
    try:
        told = json.loads((folder / f"{process}.json").read_text("utf-8"))
        looks = [_look(pid) for pid in family(told["pid"])]
    except (OSError, ValueError, KeyError):  # not started yet, killed a moment ago, or dying: it has no memory then
        return None
    kept = {name: told[name] for name in _TOLD if name in told}
    if "overruns" in told["loop"]:
        kept["overruns"] = told["loop"]["overruns"]
    if process == NETWORK:
        kept["faults"] = Counter(fault["kind"] for fault in told["faults"])
    rss_mib, open_files, threads = (sum(figures) for figures in zip(*looks, strict=True))
    return Sample(time.monotonic(), process, told["pid"], round(rss_mib, 2), int(open_files), int(threads), kept)


def _look(pid: int) -> tuple[float, int, int]:
    """Memory in MiB, open files and threads."""
    proc = Path("/proc") / str(pid)
    status = dict(line.split(":\t", 1) for line in (proc / "status").read_text("ascii").splitlines())
    return int(status["VmRSS"].split()[0]) / _KIB_PER_MIB, len(os.listdir(proc / "fd")), int(status["Threads"])


def main(folder: Path) -> None:
    """Look at every process once a second, until ended."""
    while True:
        for process in WATCHED:
            found = sample(folder, process)
            if found is not None:
                print(json.dumps({name: getattr(found, name) for name in Sample.__slots__}))
        sys.stdout.flush()
        time.sleep(EVERY_S)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
