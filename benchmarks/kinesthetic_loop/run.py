"""The kinesthetic loop at 1 kHz through python-can: lateness beside a bare loop, cost, and time from height to force.

The loop is the operator site's force path alone: read the exoskeleton, push back with five contacts, limit the forces
as the gate does, write. It runs on python-can's virtual bus, and over socketcand to the simulator's process. A bare
loop of five springs takes turns with them, so that other load on the machine affects all alike.
"""

import logging
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.kinesthetic_loop.ends import DeviceEnd, GatewayEnd, VirtualEnd
from benchmarks.kinesthetic_loop.step import PARTS, STIFFNESS_N_M, BareStep, KinestheticStep, part_costs_us
from common.faults.texts import fault_text
from common.runtime.periodic_loop import PeriodicLoop
from common.runtime.scheduling import become_timely
from studies.compared import Compared

MEASURES_THIS_MACHINE = "how late loops are on this machine"
RATE_HZ, SITE_HZ = 1000.0, 500.0
BUDGET = 0.05
"""Largest share of a 1 ms period that five contacts and the gate's limits of their forces may cost."""
BARE = "bare loop"
_SETTLE_S = 0.3
_KEEP_UP_EVERY = 20
_CONNECT_S = 20.0
_QUANTILES = (0.5, 0.9, 0.99, 0.999)
COMPARED = (Compared("answers", "p50_ms", "less", ("bus", "rate_hz"), absolute=0.5, relative=0.3),)


@dataclass(slots=True)
class Lane:
    """One loop of the study, run in slices.

    Attributes:
        name: name of its bus.
        rate_hz: rate of the loop.
        step: work of each tick.
        end: the device at the other end; None: there is none.
        late_s: lateness of each tick.
        wall_s, cpu_s: time that passed, and processor time of the loop's own thread.
        overruns: ticks more than a period late.
        measured: the step's ticks that count, from and to.
    """

    name: str
    rate_hz: float
    step: KinestheticStep | BareStep
    end: DeviceEnd | None = None
    late_s: list[float] = field(default_factory=list)
    wall_s: float = 0.0
    cpu_s: float = 0.0
    overruns: int = 0
    measured: list[tuple[int, int]] = field(default_factory=list)

    def run(self, seconds: float, ends: Sequence[DeviceEnd]) -> None:
        """Run one slice. Its start, while waiting frames are read, does not count. All ends keep up meanwhile."""
        self.step.catch_up()
        self._ticks(_SETTLE_S, ends)
        first = len(self.step.spent_s)
        began_s, cpu_s = time.monotonic(), time.thread_time()
        late_s, overruns = self._ticks(seconds, ends)
        self.wall_s += time.monotonic() - began_s
        self.cpu_s += time.thread_time() - cpu_s
        self.late_s += late_s
        self.overruns += overruns
        self.measured.append((first, len(self.step.spent_s)))

    def _ticks(self, seconds: float, ends: Sequence[DeviceEnd]) -> tuple[list[float], int]:
        loop, late_s = PeriodicLoop(1.0 / self.rate_hz), []
        for tick in range(round(seconds * self.rate_hz)):
            late_s.append(loop.wait())
            self.step.tick(time.monotonic())
            if tick % _KEEP_UP_EVERY == 0:
                for end in ends:
                    end.keep_up()
        return late_s, loop.overruns


def run(
    *, quick: bool = False, seed: int = 0, progress: Callable[[float | str], object] = lambda _: None
) -> dict[str, Any]:
    """Measure; `seed` has no effect, since nothing is random."""
    become_timely()
    logging.getLogger("can").setLevel(logging.ERROR)  # a frame that the network splits needs no warning
    return measure(seconds=1.0 if quick else 5.0, rounds=2 if quick else 6, progress=progress)


def measure(
    seconds: float,
    rounds: int,
    buses: Sequence[str] = ("virtual", "socketcand"),
    progress: Callable[[float | str], object] = lambda _: None,
) -> dict[str, Any]:
    """Run all loops in turn, `rounds` times `seconds` each; returns the result of each."""
    parts = part_costs_us(repeat=2000)
    with ExitStack() as opened:
        lanes = [Lane(BARE, RATE_HZ, BareStep())]
        for bus in buses:
            lanes += _lanes(bus, opened)
        ends = [lane.end for lane in lanes if lane.end and lane.rate_hz == RATE_HZ]
        for number in range(rounds):
            for place, lane in enumerate(lanes):
                progress((number + place / len(lanes)) / rounds)
                lane.run(seconds, ends)
        rows = [_row(lane) for lane in lanes]
        ways = [(lane, lane.step, lane.end) for lane in lanes if isinstance(lane.step, KinestheticStep) and lane.end]
        answers = [_answers(lane, step, end) for lane, step, end in ways]
        faults = [f"{lane.name}: {fault_text(step.fault)}" for lane, step, _ in ways if step.fault]
    dear = [row for row in rows if row["rate_hz"] == RATE_HZ and row["step_us"] > BUDGET * 1e6 / RATE_HZ]
    problems = [
        f"{row['bus']}: five contacts and their limits cost {row['step_us']:.0f} us, more than {BUDGET:.0%} of 1 ms"
        for row in dear
    ]
    return {
        "stiffness_n_m": STIFFNESS_N_M,
        "budget": BUDGET,
        "loops": rows,
        "answers": answers,
        "parts_us": parts,
        "problems": faults + problems,
    }


def tables(data: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """Tables of the loops, of the parts of a step, and of the time from height to force."""
    flat = [{name: value for name, value in row.items() if not isinstance(value, list)} for row in data["loops"]]
    names = dict.fromkeys(name for row in flat for name in row)
    loops = [{name: row.get(name) for name in names} for row in flat]
    answers = [{name: value for name, value in row.items() if not isinstance(value, list)} for row in data["answers"]]
    parts = [{"part": name, "cost_us": cost_us} for name, cost_us in data["parts_us"].items()]
    return {"loops": loops, "answers": answers, "parts": parts}


def _lanes(bus: str, opened: ExitStack) -> list[Lane]:
    end: DeviceEnd = opened.enter_context(closing(VirtualEnd() if bus == "virtual" else GatewayEnd()))
    step = KinestheticStep(end.address)
    opened.callback(step.exoskeleton.line.close)
    deadline_s = time.monotonic() + _CONNECT_S
    while not step.connect(time.monotonic()):
        if time.monotonic() > deadline_s:
            raise RuntimeError(f"no heights over {end.address}: {step.exoskeleton.line.problem}")
        time.sleep(0.01)
    return [Lane(bus, rate_hz, step, end) for rate_hz in (RATE_HZ, SITE_HZ)]


def _row(lane: Lane) -> dict[str, Any]:
    late_us = np.array(lane.late_s) * 1e6
    row: dict[str, Any] = {
        "bus": lane.name,
        "rate_hz": lane.rate_hz,
        "ticks": len(late_us),
        "done_hz": len(late_us) / lane.wall_s,
        **{f"late_p{100.0 * q:g}_us": float(np.quantile(late_us, q)) for q in _QUANTILES},
        "late_max_us": float(late_us.max()),
        "overruns": lane.overruns,
        "cpu_share": lane.cpu_s / lane.wall_s,
        "late_us": np.quantile(late_us, np.linspace(0.0, 1.0, 201)).tolist(),
    }
    spent_us = 1e6 * np.concatenate([lane.step.spent_s[first:last] for first, last in lane.measured])
    if isinstance(lane.step, BareStep):
        return {**row, "step_us": float(np.median(spent_us))}
    step_us = spent_us[:, PARTS.index("contacts")] + spent_us[:, PARTS.index("limits")]
    row["step_us"] = float(np.median(step_us))
    row |= {f"{part}_us": float(each) for part, each in zip(PARTS, np.median(spent_us, axis=0), strict=True)}
    return {**row, "unsent": lane.step.exoskeleton.line.unsent}


def _answers(lane: Lane, step: KinestheticStep, end: DeviceEnd) -> dict[str, Any]:
    """Time from measuring heights to the arrival of the first forces that answer them, by the device's own clock.

    Heights come at 500 Hz. A loop at 1 kHz answers each twice, and only the first answer counts.
    """
    arrived_s, answered_s = np.array(end.arrivals_s()), np.array(step.answered_s)
    count = min(len(arrived_s), len(answered_s))
    took_ms = 1e3 * (arrived_s[:count] - answered_s[:count])
    first_answer = np.diff(answered_s[:count], prepend=-np.inf) > 0.0
    slices = [slice(first, min(last, count)) for first, last in lane.measured]
    counted = np.concatenate([took_ms[each][first_answer[each]] for each in slices])
    counted = counted[np.isfinite(counted)]
    return {
        "bus": lane.name,
        "rate_hz": lane.rate_hz,
        "answers": len(counted),
        "mean_ms": float(counted.mean()),
        **{f"p{100.0 * q:g}_ms": float(np.quantile(counted, q)) for q in _QUANTILES},
        "max_ms": float(counted.max()),
        "took_ms": np.quantile(counted, np.linspace(0.0, 1.0, 201)).tolist(),
    }
