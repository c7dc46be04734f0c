"""`python -m common.health FILE [--state STATE]`: whether a process of a session may be relied on, for supervisors.

*Fresh*: it has rewritten its status file lately, and what it acts on or shows is not old. *Safe*: no fault is latched,
no device is missing, the list of trusted keys is sound. A site that waits for somebody to engage is healthy. A state
is believed of a young file only.
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
_ILLS = ("missing", "stale", "keys")
"""What a process says in its own words beside a fault, and each is empty where there is none."""


class NoStatus(ValueError):
    """A status file that is not there, or is none."""


def read_status(status: Path, now_ns: int) -> tuple[dict[str, Any], float]:
    """What a status file tells, and how long ago it was written, s.

    Raises:
        NoStatus: it cannot be read, or is no status file.
    """
    try:
        told = read_json(status)
        return dict(told), (now_ns - int(told["time_ns"])) * 1e-9
    except OSError as error:
        raise NoStatus(f"{status}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, OverflowError):
        raise NoStatus(f"{status}: not a status file") from None


def young(age_s: float) -> bool:
    """Whether a status of this age says that its process lives; a negative age is from before the machine started."""
    return 0.0 <= age_s < OLDEST_S


def ill(status: Path, now_ns: int, state: str | None = None) -> str:
    """What is wrong with the process that writes `status`; empty when nothing is.

    Args:
        status: the process's status file.
        now_ns: monotonic clock of the machine on which the process runs.
        state: the session state that a site must be in, such as `engaged`; any by default.
    """
    try:
        told, age_s = read_status(status, now_ns)
    except NoStatus as problem:
        return str(problem)
    if not young(age_s):
        return f"{status}: {SILENT}, {seconds_old(age_s)}, expected less than {OLDEST_S:g} s"
    if told.get("state") == ENDED:
        return f"{status}: the process has ended"
    if fault := told.get("fault"):
        return f"{status}: fault: {fault['text'] if isinstance(fault, dict) else fault}"
    for name in _ILLS:
        if told.get(name):
            return f"{status}: {name}: {told[name]}"
    if state is not None and told.get("state") != state:
        why = told.get("paused") or told.get("refusal") or ""
        return f"{status}: {told.get('state', 'no session state')}, expected {state}" + (f" ({why})" if why else "")
    return ""


def main(arguments: list[str] | None = None) -> int:
    """Exit code 0 when healthy; else 1 and one line that says why."""
    parser = argparse.ArgumentParser(prog="python -m common.health", description=__doc__)
    parser.add_argument("status", type=Path, metavar="FILE", help="status file of the process")
    parser.add_argument("--state", help="session state that a site must be in")
    options = parser.parse_args(arguments)
    problem = ill(options.status, time.monotonic_ns(), options.state)
    if problem:
        print(printable(problem), file=sys.stderr)
    return 1 if problem else 0


if __name__ == "__main__":
    sys.exit(main())
