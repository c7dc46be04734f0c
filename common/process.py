"""Starts a process of a session: its command line, configuration and log, and a clean end on a signal."""

import argparse
import logging
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn, TypeVar

from pydantic import BaseModel

from common.config.file import load_config
from common.files.printable import printable
from common.logs import LogForm, log_to_stderr

log = logging.getLogger(__name__)

_C = TypeVar("_C", bound=BaseModel)


class StopSignal:
    """True after SIGTERM, SIGINT, or SIGHUP of a closed terminal; `nohup` lets a process ignore the last one."""

    def __init__(self) -> None:
        self.stopped = False
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            if number != signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._stop)

    def __call__(self) -> bool:
        """Return whether to stop."""
        return self.stopped

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self.stopped = True


def run_process(name: str, config: Path, model: type[_C], run: Callable[[_C, Callable[[], bool]], None]) -> None:
    """Run one process of a session until a signal ends it; raises the exceptions of `load_config` and `run`.

    Raises:
        SystemExit: the configuration selects JSON lines, and bad input was logged as one; the code is 2.
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


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}\n")


def room_main(room: str, processes: dict[str, tuple[str, Any, Callable[[Any, Callable[[], bool]], None]]]) -> int:
    """Run `python -m ROOM [PROCESS] --config FILE`; return the exit code, 2 with one line for bad input.

    Args:
        room: name of the room's package.
        processes: for each PROCESS the name in its log, the model of its configuration, and the function that runs it.
    """
    parser = _Parser(prog=f"python -m {room}")
    if len(processes) == 1:
        parser.set_defaults(process=next(iter(processes)))
    else:
        parser.add_argument("process", choices=sorted(processes))
    parser.add_argument("--config", type=Path, required=True, help="TOML file of this process")
    arguments = parser.parse_args()
    name, model, run = processes[arguments.process]
    try:
        run_process(name, arguments.config, model, run)
    except (ValueError, KeyError, OSError) as error:
        print(f"{parser.prog}: {printable(' '.join(str(error).split()))}", file=sys.stderr)
        return 2
    return 0
