"""Run a simulated world in real time: bytes as they arrive, physics every 2 ms on absolute deadlines."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from common.runtime.periodic_loop import PeriodicLoop
from common.runtime.rate_monitor import RateMonitor, spent
from common.runtime.scheduling import become_timely
from common.runtime.status_file import StatusFile
from sim_sensors.ports.select_loop import SelectLoop

STEP_S = 0.002
MOST_STEPS = 25
"""Most steps made up for after a stall (50 ms); further time is lost and counted. To the sites, a world that lags more
looks like devices that ignore commands."""


class World(Protocol):
    """Devices with their physics."""

    def step(self, now_s: float) -> None:
        """Advance by STEP_S to the time `now_s`."""

    def figures(self) -> dict[str, object]:
        """Return the world's part of the status file."""


@dataclass(slots=True)
class StepClock:
    """Count the steps of the world that are due at a time of the real clock.

    Attributes:
        start_s: real time of the world's time 0.
        steps: steps made.
        lost_s: world time given up after stalls.
    """

    start_s: float
    steps: int = 0
    lost_s: float = 0.0

    def due(self, now_s: float) -> list[float]:
        """Return the real times of the steps that are due, oldest first."""
        count = int((now_s - self.start_s) / STEP_S + 1e-6) - self.steps
        if count > MOST_STEPS:
            skipped = (count - MOST_STEPS) * STEP_S
            self.start_s += skipped
            self.lost_s += skipped
            count = MOST_STEPS
        times = [self.start_s + (self.steps + n) * STEP_S for n in range(1, count + 1)]
        self.steps += len(times)
        return times


def run_world(world: World, sockets: SelectLoop, stop: Callable[[], bool], name: str, status: Path | None) -> None:
    """Run until `stop()`, and rewrite the `status` file every second with the loop's and the world's figures."""
    become_timely()
    clock = StepClock(sockets.now())
    periodic = PeriodicLoop(STEP_S, now=sockets.now, sleep=sockets.serve)
    held = RateMonitor(1.0 / STEP_S)
    status_file = StatusFile(status, name, periodic)
    for now_s in sockets.ticks(periodic, stop):
        for step_s in clock.due(now_s):
            world.step(step_s)
        if status_file.due(now_s):
            rate = held.look(now_s, spent(periodic))
            status_file.write(now_s, {"lost_s": clock.lost_s, **rate, **world.figures()})
