"""Drives a session in lock step and measures the cost of each tick, by the fingers' activity."""

import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.runtime_cost.stages import StageClock
from common.runtime.reference_step import reference_step
from sim_sensors.operator_devices import OperatorDevices
from sim_sensors.remote_devices import RemoteDevices
from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.testbed.lockstep import STEP_S, LockStep, SimulatedDevices, sites

SCENE = Path(__file__).with_name("activities.toml")
SCRIPT_S = 14.0
"""Duration of one pass through the scene's script, including the time before the hand begins, s."""
DOING = ("free", "tapping", "resting", "stroking")
"""Activity of the fingers, by the number of the script's mode."""
TICK = "tick"
"""Name of the whole tick among the stages."""
_REFERENCE_EVERY = 25
"""Ticks between two reference steps, which spread over the whole run."""


@dataclass(slots=True)
class Spent:
    """Processor time of a run, ns.

    Attributes:
        ticks: times of each tick, by process, activity of the fingers, and stage.
        reference: times of each reference step.
    """

    ticks: dict[tuple[str, str, str], list[int]] = field(default_factory=lambda: defaultdict(list))
    reference: list[int] = field(default_factory=list)

    def rows(self, fingers: int) -> list[dict[str, Any]]:
        """Return a row for each process, activity and stage; a stage that did not run in a tick cost 0 in it."""
        reference_ns = float(np.median(self.reference))
        found = []
        for (process, doing, stage), spent in self.ticks.items():
            count = len(self.ticks[process, doing, TICK])
            ns = np.zeros(count)
            ns[: len(spent)] = spent
            found.append(
                {
                    "fingers": fingers,
                    "process": process,
                    "doing": doing,
                    "stage": stage,
                    "ticks": count,
                    "mean_us": round(float(ns.mean()) * 1e-3, 2),
                    "p50_us": round(float(np.percentile(ns, 50)) * 1e-3, 2),
                    "p99_us": round(float(np.percentile(ns, 99)) * 1e-3, 2),
                    "reference_steps": round(float(ns.mean()) / reference_ns, 3),
                }
            )
        return found


class _TimedDevices(SimulatedDevices):
    """Simulated devices with timed steps.

    Attributes:
        spent_ns: processor time of the last step, by process.
    """

    def __init__(self, configs: dict[str, Path], lockstep: LockStep) -> None:
        super().__init__(configs, lockstep.now_s)
        self.spent_ns: dict[str, int] = {}

    def advance(self, name: str, devices: OperatorDevices | RemoteDevices, now_s: float) -> None:
        self.spent_ns[name] = timed(partial(super().advance, name, devices, now_s))


def timed(work: Callable[[], object]) -> int:
    """Run some work and return its processor time in this thread, ns."""
    begun_ns = time.thread_time_ns()
    work()
    return time.thread_time_ns() - begun_ns


def measure(fingers: int, seed: int, folder: Path, progress: Callable[[float], object] = lambda _: None) -> Spent:
    """Run one pass through the script.

    Args:
        fingers: number of fingers, 1 to 5.
        seed: seed of the simulated devices and the hand.
        folder: folder for keys, configurations and recordings.
        progress: receives the share done, 0..1.

    Raises:
        NotEngaged: the sites did not find their devices or each other.
    """
    configs = prepare(DemoOptions(fingers=fingers, seed=seed, scene=str(SCENE)), folder)
    lockstep, spent = LockStep(), Spent()
    simulators = _TimedDevices(configs, lockstep)
    try:
        with sites(lockstep, configs, StageClock):
            lockstep.engage(simulators)
            steps = round(SCRIPT_S / STEP_S)
            for number in range(steps):
                lockstep.step(simulators)
                doing = DOING[simulators.operator.hand.mode]
                for process, site in lockstep.due():
                    assert isinstance(site.contain, StageClock)
                    spent.ticks[process, doing, TICK].append(timed(partial(site.tick, lockstep.now_ns())))
                    for stage, ns in site.contain.take_spent_ns().items():
                        spent.ticks[process, doing, stage].append(ns)
                for process, ns in simulators.spent_ns.items():
                    spent.ticks[process, doing, TICK].append(ns)
                if number % _REFERENCE_EVERY == 0:
                    spent.reference.append(timed(reference_step))
                    progress(number / steps)
            assert lockstep.remote.server.both_engaged, lockstep.remote.figures()
    finally:
        simulators.close()
    return spent
