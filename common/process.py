"""What every process of a session shares: a clean end on a signal, and its figures in a status file."""

import argparse
import json
import logging
import os
import resource
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any, TypeVar

from pydantic import BaseModel

from common.config import load_config
from common.ladder import NOTICE_S
from common.logs import LogForm, log_to_stderr
from common.loop import PeriodicLoop
from common.printable import printable
from common.private_file import create_private, refuse_link

log = logging.getLogger(__name__)

_C = TypeVar("_C", bound=BaseModel)


class StopSignal:
    """True once SIGTERM or SIGINT came; a second one is not needed."""

    def __init__(self) -> None:
        self.stopped = False
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._stop)

    def __call__(self) -> bool:
        """Whether to stop."""
        return self.stopped

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self.stopped = True


def rss_mib() -> float:
    """Largest memory that this process has had resident so far, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


class StatusFile:
    """Rewrites a small JSON file once a second; the whole file is replaced, so a reader never sees half of one.

    Only the user of the process can read it.
    """

    def __init__(self, path: Path | None, process: str, loop: PeriodicLoop | None = None):
        """Write to `path`, or nowhere.

        Raises:
            OSError: `path` is a symbolic link.
        """
        if path is not None:
            refuse_link(path)
        self._path = path
        self._refused = ""
        self._process = process
        self._loop = loop
        self._due_s = 0.0
        self._start_s = time.monotonic()

    def due(self, t_s: float) -> bool:
        """Whether it is time to write."""
        return self._path is not None and t_s >= self._due_s

    def write(self, t_s: float, figures: dict[str, object]) -> None:
        """Write the loop's figures and `figures`; a full disk is no reason to stop."""
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
            part.unlink(missing_ok=True)  # left by a process that was killed, or put there by somebody else
            with create_private(part) as file:
                file.write(json.dumps(status).encode())
            part.replace(self._path)
            self._refused = ""
        except OSError as error:
            if str(error) != self._refused:
                log.warning("status file: %s", error)
            self._refused = str(error)


def _figures(loop: PeriodicLoop | None) -> dict[str, object]:
    """How timely a loop is; a process without one has nothing to tell."""
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


def run_process(name: str, config: Path, model: type[_C], run: Callable[[_C, Callable[[], bool]], None]) -> None:
    """Run one process of a session until it is told to end; raises what `load_config` and `run` raise.

    Where the configuration wants JSON lines, bad input is one too, and ends the process with exit code 2.
    """
    log_to_stderr(name)
    loaded = load_config(config, model)
    form: LogForm = getattr(loaded, "log", "text")
    log_to_stderr(name, form)
    try:
        run(loaded, StopSignal())
    except (ValueError, KeyError, OSError) as error:
        if form == "text":
            raise
        log.critical("%s", " ".join(str(error).split()))
        raise SystemExit(2) from None


def room_main(processes: dict[str, tuple[Any, Callable[[Any, Callable[[], bool]], None]]]) -> int:
    """`python -m ROOM [PROCESS] --config FILE`; returns the exit code, 2 with one line for bad input."""
    parser = argparse.ArgumentParser()
    only = next(iter(processes)) if len(processes) == 1 else None
    if only is None:
        parser.add_argument("process", choices=sorted(processes))
    parser.add_argument("--config", type=Path, required=True, help="TOML file of this process")
    arguments = parser.parse_args()
    name = only or arguments.process
    try:
        run_process(name, arguments.config, *processes[name])
    except (ValueError, OSError) as error:
        print(f"{name}: {printable(str(error))}", file=sys.stderr)
        return 2
    return 0
