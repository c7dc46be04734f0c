"""Runs one command of teletaction with the clocks of a host of its own, until its input ends.

    host_process.py DRIFT STEP_S COMMAND...

All clocks of the process run fast by DRIFT, s/s, from its start. The first line that it prints is `PID START_NS`: its
process, and its monotonic clock at that moment. SIGUSR1 steps its wall clock by STEP_S, as NTP does; it then prints by
how much the wall clock is ahead of the monotonic clock, ns, before and after the step.
"""

import os
import runpy
import signal
import sys
import threading
import time
from functools import partial

_NS = 10**9


class HostClocks:
    """Clocks of one host, made from those of the machine."""

    def __init__(self, drift: float):
        """Let all clocks run fast by `drift`, s/s, from now on."""
        self._drift = drift
        self._read_ns = time.clock_gettime_ns
        self._wall_step_ns = 0
        self._start_ns = {
            clock: time.clock_gettime_ns(clock)
            for clock in (time.CLOCK_MONOTONIC, time.CLOCK_BOOTTIME, time.CLOCK_REALTIME)
        }

    @property
    def start_ns(self) -> int:
        """Monotonic clock at which the drift begins, ns."""
        return self._start_ns[time.CLOCK_MONOTONIC]

    def now_ns(self, clock: int) -> int:
        """Read a clock, ns."""
        start_ns, machine_ns = self._start_ns.get(clock), self._read_ns(clock)
        if start_ns is None:
            return machine_ns
        stepped_ns = self._wall_step_ns if clock == time.CLOCK_REALTIME else 0
        return machine_ns + round(self._drift * (machine_ns - start_ns)) + stepped_ns

    def install(self) -> None:
        """Replace the clocks of `time` in this process."""
        monotonic_ns = partial(self.now_ns, time.CLOCK_MONOTONIC)
        wall_ns = partial(self.now_ns, time.CLOCK_REALTIME)
        for name, clock in (
            ("clock_gettime_ns", self.now_ns),
            ("monotonic_ns", monotonic_ns),
            ("monotonic", lambda: monotonic_ns() / _NS),
            ("time_ns", wall_ns),
            ("time", lambda: wall_ns() / _NS),
        ):
            setattr(time, name, clock)

    def step_wall_clock(self, step_ns: int) -> tuple[int, int]:
        """Step the wall clock; return its lead over the monotonic clock before and after, ns."""
        before_ns = time.time_ns() - time.monotonic_ns()
        self._wall_step_ns += step_ns
        return before_ns, time.time_ns() - time.monotonic_ns()


def _end_with_input() -> None:
    while os.read(0, 1):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


def main(drift: float, step_s: float, command: list[str]) -> None:
    """Install the clocks, then run the command."""
    clocks = HostClocks(drift)
    clocks.install()

    def step(*_: object) -> None:
        os.write(1, b"%d %d\n" % clocks.step_wall_clock(round(step_s * _NS)))

    signal.signal(signal.SIGUSR1, step)
    print(os.getpid(), clocks.start_ns, flush=True)
    threading.Thread(target=_end_with_input, daemon=True).start()
    sys.argv = ["teletaction", *command]
    runpy.run_module("teletaction", run_name="__main__")


if __name__ == "__main__":
    main(float(sys.argv[1]), float(sys.argv[2]), sys.argv[3:])
