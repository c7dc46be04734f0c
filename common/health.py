"""Checks for a supervisor that a process of a session is healthy: `python -m common.health FILE [--state STATE]`.

A healthy process is fresh: its status file is recent, and so is the data on which it acts or which it shows. It is
also safe: no fault is latched, no device is missing, and the list of trusted keys is sound. A site that waits for a
person to engage is healthy. Only a recent file shows the state of its process.
"""

import argparse
import sys
import time
from pathlib import Path
from typing import Any

from common.files.printable import printable
from common.files.read_files import read_json
from common.link.session_display import ENDED, SILENT, seconds_old
from common.timing.timeouts import SUPERVISOR_WATCHDOG_S

OLDEST_S = SUPERVISOR_WATCHDOG_S
"""Maximum age of the status file of a healthy process, s."""
_PROBLEMS = ("missing", "stale", "keys")
"""Fields of a status file that describe a problem other than a fault; empty without one."""


class NoStatus(ValueError):
    """A status file that does not exist or is invalid."""


def read_status(status: Path, now_ns: int) -> tuple[dict[str, Any], float]:
    """Return the content of a status file, and its age, s.

    Raises:
        NoStatus: the file cannot be read, or is no status file.
    """
    try:
        content = read_json(status)
        return dict(content), (now_ns - int(content["time_ns"])) * 1e-9
    except OSError as error:
        raise NoStatus(f"{status}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, OverflowError):
        raise NoStatus(f"{status}: not a status file") from None


def young(age_s: float) -> bool:
    """Return whether a status of this age, s, shows a living process; one from before a reboot has a negative age."""
    return 0.0 <= age_s < OLDEST_S


def find_problem(status: Path, now_ns: int, state: str | None = None) -> str:
    """Return the first problem of the process that writes `status`; empty for a healthy one.

    Args:
        status: the process's status file.
        now_ns: monotonic clock of the machine on which the process runs.
        state: the session state that a site must be in, such as `engaged`; any by default.
    """
    try:
        content, age_s = read_status(status, now_ns)
    except NoStatus as problem:
        return str(problem)
    if not young(age_s):
        return f"{status}: {SILENT}, {seconds_old(age_s)}, expected less than {OLDEST_S:g} s"
    if content.get("state") == ENDED:
        return f"{status}: the process has ended"
    if fault := content.get("fault"):
        return f"{status}: fault: {fault.get('text', fault) if isinstance(fault, dict) else fault}"
    for name in _PROBLEMS:
        if content.get(name):
            return f"{status}: {name}: {content[name]}"
    if state is not None and content.get("state") != state:
        why = content.get("paused") or content.get("refusal") or ""
        return f"{status}: {content.get('state', 'no session state')}, expected {state}" + (f" ({why})" if why else "")
    return ""


def main(arguments: list[str] | None = None) -> int:
    """Return exit code 0 for a healthy process; else 1, after one line with the problem."""
    parser = argparse.ArgumentParser(prog="python -m common.health", description=__doc__)
    parser.add_argument("status", type=Path, metavar="FILE", help="status file of the process")
    parser.add_argument("--state", help="session state that a site must be in")
    options = parser.parse_args(arguments)
    problem = find_problem(options.status, time.monotonic_ns(), options.state)
    if problem:
        print(printable(problem), file=sys.stderr)
    return 1 if problem else 0


if __name__ == "__main__":
    sys.exit(main())
