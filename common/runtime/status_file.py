"""Writes the status file of a process: figures of its loop and its own, as JSON."""

import json
import logging
import os
import resource
import time
from pathlib import Path

from common.files.no_room import NO_ROOM
from common.files.private_file import create_private, refuse_link
from common.runtime.periodic_loop import PeriodicLoop
from common.timing.timeouts import NOTICE_S

log = logging.getLogger(__name__)


def rss_mib() -> float:
    """Return the peak resident memory of this process, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


class StatusFile:
    """Replaces a small JSON file once a second, so that a reader never sees a partial file.

    Only the user of the process can read it. On a full disk, the file is overwritten instead.
    """

    def __init__(self, path: Path | None, process: str, loop: PeriodicLoop | None = None):
        """Write to `path`, or nothing for None; raises OSError where `path` is a symbolic link."""
        if path is not None:
            refuse_link(path)
        self._path = path
        self._refused = ""
        self._process = process
        self._loop = loop
        self._due_s = 0.0
        self._start_s = time.monotonic()

    def due(self, t_s: float) -> bool:
        """Return whether it is time to write."""
        return self._path is not None and t_s >= self._due_s

    def write(self, t_s: float, figures: dict[str, object]) -> None:
        """Write the loop's figures and `figures`; an error, such as a full disk, is only logged."""
        self._due_s = t_s + NOTICE_S
        if self._path is None:
            return
        wall_s = max(1e-9, time.monotonic() - self._start_s)
        status = {
            "process": self._process,
            "pid": os.getpid(),
            "time_ns": time.monotonic_ns(),
            "rss_mib": round(rss_mib(), 1),
            "loop": {**_figures(self._loop), "cpu": round(time.process_time() / wall_s, 3)},
            **figures,
        }
        part = self._path.with_name(self._path.name + ".part")
        try:
            refuse_link(self._path)
            part.unlink(missing_ok=True)  # left by a killed process, or created by another user
            content = json.dumps(status).encode()
            try:
                with create_private(part) as file:
                    file.write(content)
            except OSError as error:
                part.unlink(missing_ok=True)
                if error.errno not in NO_ROOM or not _overwrite(self._path, content):
                    raise
            else:
                part.replace(self._path)
            self._refused = ""
        except OSError as error:
            if str(error) != self._refused:
                log.warning("status file: %s", error)
            self._refused = str(error)


def _overwrite(path: Path, content: bytes) -> bool:
    """Write into a file's own blocks, as a full disk has no others; return False where there is no room in them."""
    if not path.exists():
        return False
    with open(os.open(path, os.O_WRONLY | os.O_NOFOLLOW | os.O_CLOEXEC), "wb") as file:
        fits = os.fstat(file.fileno()).st_blocks * 512 >= len(content)
        if fits:
            file.write(content)
            file.truncate()
    return fits


def _figures(loop: PeriodicLoop | None) -> dict[str, object]:
    """Return the loop's lateness figures; empty for a process without a loop."""
    if loop is None:
        return {}
    return {
        "period_ms": loop.period_s * 1e3,
        "ticks": loop.ticks,
        "late_p50_us": round(loop.late_us(0.5), 1),
        "late_p99_us": round(loop.late_us(0.99), 1),
        "late_max_us": round(loop.late_max_s * 1e6, 1),
        "overruns": loop.overruns,
        "missed": loop.missed,
    }
