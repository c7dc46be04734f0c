"""Runs a simulated world in real time: bytes as they arrive, physics every 2 ms on absolute deadlines."""

import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from common.loop import PeriodicLoop, sharpen_timers
from sim_sensors.select_loop import SelectLoop

STEP_S = 0.002
_MOST_STEPS = 25
"""After a stall up to 50 ms of physics are made up for; the rest is lost, and counted."""
_STATUS_S = 1.0


class World(Protocol):
    """Devices with their physics."""

    def step(self, now_s: float) -> None:
        """Advance by STEP_S to the moment `now_s`."""

    def figures(self) -> dict[str, object]:
        """What the status file should tell of it."""


@dataclass(slots=True)
class StepClock:
    """How many steps of the world are due at a time of the real clock.

    Attributes:
        start_s: real time of the world's time 0.
        steps: steps made.
        lost_s: world time given up after stalls.
    """

    start_s: float
    steps: int = 0
    lost_s: float = field(default=0.0)

    def due(self, now_s: float) -> list[float]:
        """Real times of the steps to make now, oldest first."""
        count = int((now_s - self.start_s) / STEP_S + 1e-6) - self.steps
        if count > _MOST_STEPS:
            skipped = (count - _MOST_STEPS) * STEP_S
            self.start_s += skipped
            self.lost_s += skipped
            count = _MOST_STEPS
        times = [self.start_s + (self.steps + n) * STEP_S for n in range(1, count + 1)]
        self.steps += len(times)
        return times


def run_world(world: World, sockets: SelectLoop, stop: Callable[[], bool], name: str, status: Path | None) -> None:
    """Run until `stop()`; rewrites the `status` file every second with the loop's and the world's figures."""
    sharpen_timers()
    periodic = PeriodicLoop(STEP_S, now=sockets.now, sleep=sockets.serve)
    clock = StepClock(sockets.now())
    status_due_s, status_from_s, cpu_from_s = clock.start_s, clock.start_s, time.process_time()
    while not stop():
        if periodic.wait() > STEP_S / 4.0:
            sockets.serve(0.0)  # there was no waiting, so nothing was handled since the last tick
        now_s = sockets.now()
        for step_s in clock.due(now_s):
            world.step(step_s)
        if status is not None and now_s >= status_due_s:
            cpu_s = time.process_time()
            used = (cpu_s - cpu_from_s) / (now_s - status_from_s) if now_s > status_from_s else 0.0
            figures = _loop_figures(periodic, clock) | {"cpu": round(used, 4)}
            _write_status(status, {"process": name, "loop": figures, **world.figures()})
            status_due_s, status_from_s, cpu_from_s = now_s + _STATUS_S, now_s, cpu_s


def _loop_figures(periodic: PeriodicLoop, clock: StepClock) -> dict[str, float]:
    return {
        "period_ms": STEP_S * 1e3,
        "ticks": periodic.ticks,
        "late_p50_us": periodic.late_us(0.5),
        "late_p99_us": periodic.late_us(0.99),
        "overruns": periodic.overruns,
        "lost_s": clock.lost_s,
    }


def _write_status(path: Path, figures: dict[str, object]) -> None:
    """Replace the status file as a whole: a reader never sees half of one."""
    status = {"pid": os.getpid(), "time_ns": time.monotonic_ns(), **figures}
    part = path.with_name(path.name + ".part")
    part.write_text(json.dumps(status), "utf-8")
    part.replace(path)
