"""Exploration modes from noisy force and motion: time right, wrong switches, latency, and the speed of taps.

Hands explore at random (`scenes`). Sensors are 1 to 10 times as coarse and noisy as
nominal. Ticks are late, and some are lost. The baseline of the mode machine is thresholds on each sample alone.
"""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from common.exploration.exploration_mode import ModeDetector
from common.exploration.hand_motion import HandMotion
from common.wire.messages import ExplorationMode
from sim_sensors.traces.commanded_hand import TICK_S
from sim_sensors.traces.simulated_exploration import Explored, sense
from studies.compared import Compared
from studies.exploration_modes.judge import (
    JUDGED,
    MACHINE,
    PLAIN,
    Machine,
    Reported,
    latencies,
    listen,
    longest_run,
    tap_speeds,
    wrong_switches,
)
from studies.exploration_modes.plain_thresholds import PlainThresholds
from studies.exploration_modes.scenes import BARELY, SCENES, scene
from studies.pieces import HERE, Work
from studies.running import Progress, tables_of


class _OneFinger:
    """The mode machine of a hand with one finger."""

    def __init__(self) -> None:
        self._hand = HandMotion()
        self._finger = ModeDetector(self._hand)
        self.approach_m_s = 0.0

    @property
    def began(self) -> bool:
        return self._finger.began

    def step(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> ExplorationMode:
        self._hand.step(t_s, x_m, y_m)
        mode = self._finger.step(t_s, force_n, z_m)
        self.approach_m_s = self._finger.approach_m_s
        return mode


METHODS: dict[str, Callable[[], Machine]] = {MACHINE: _OneFinger, PLAIN: PlainThresholds}
NOISES = (1.0, 3.0, 5.0, 10.0)
SEEDS, QUICK_SEEDS = 100, 8
SPEEDS_M_S = (0.015, 0.03, 0.06, 0.12, 0.4)
SOON_S = 0.005
tables = tables_of("levels", "scenes", "latencies", "taps", "barely")
COMPARED = (
    Compared("levels", "right", "more", ("noise",), {"method": MACHINE}, absolute=0.005),
    Compared("levels", "wrong_switches", "less", ("noise",), {"method": MACHINE}, absolute=5.0, relative=0.2),
    Compared("levels", "invented_taps", "less", ("noise",), {"method": MACHINE}, absolute=5.0, relative=0.2),
    Compared("latencies", "p50_s", "less", ("noise", "switch"), {"method": MACHINE}, absolute=0.005, relative=0.2),
)


class _Count:
    """Counts of one method at one level of noise, over all scenes."""

    def __init__(self) -> None:
        self.number, self.ticks, self.right, self.never = (Counter[str]() for _ in range(4))
        self.longest_run = 0
        self.late_s: dict[str, list[float]] = defaultdict(list)
        self.taps: list[tuple[float, float]] = []

    def add(self, more: "_Count") -> None:
        """Add another count to this one."""
        for counted in ("number", "ticks", "right", "never"):
            getattr(self, counted).update(getattr(more, counted))
        for name, late_s in more.late_s.items():
            self.late_s[name] += late_s
        self.longest_run = max(self.longest_run, more.longest_run)
        self.taps += more.taps

    def take(self, kind: str, explored: Explored, reported: Reported) -> None:
        true = explored.mode
        self.ticks[kind] += len(true)
        self.right[kind] += int(np.count_nonzero(reported.mode == true))
        wrong = wrong_switches(true, reported.mode)
        self.number["true switches"] += int(np.count_nonzero(np.diff(true)))
        self.number["switches"] += len(wrong)
        self.number["wrong switches"] += sum(wrong)
        self.longest_run = max(self.longest_run, longest_run(wrong))
        for name, late_s, stood_still in latencies(true, reported):
            if late_s is None:
                self.never[name] += 1
            else:
                self.late_s[name].append(late_s)
            if name == "contact":
                self.number["stood still" if stood_still else "contacts"] += 1
                self.number["soon"] += not stood_still and late_s is not None and late_s <= SOON_S
        speeds = list(tap_speeds(explored, reported))
        self.taps += [(true_m_s, m_s) for true_m_s, m_s in speeds if m_s is not None]
        self.number["invented taps"] += max(0, len(reported.taps) - len(speeds))


_Counts = dict[tuple[str, float], _Count]


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Explore, sense and judge; returns all rows. All tables but `barely` cover only SCENES."""
    counts, barely = _counts(), _counts()
    for each, each_barely in work([(_explored, (seed, n)) for n in range(QUICK_SEEDS if quick else SEEDS)], progress):
        for key in counts:
            counts[key].add(each[key])
            barely[key].add(each_barely[key])
    ways = {"levels": _level, "scenes": _scenes, "latencies": _latencies, "taps": _taps}
    found = {name: _rows(counts, way) for name, way in ways.items()} | {"barely": _rows(barely, _level)}
    return {"seconds": TICK_S * sum(counts[MACHINE, JUDGED].ticks.values())} | found


def _counts() -> _Counts:
    return {(method, noise): _Count() for method in METHODS for noise in NOISES}


def _explored(seed: int, number: int) -> tuple[_Counts, _Counts]:
    """One hand in each kind of scene: counts over SCENES, and over BARELY."""
    counts, barely = _counts(), _counts()
    for kind in (*SCENES, BARELY):
        explored = scene(kind, 1000 * seed + number)
        for noise in NOISES:
            sensed = sense(explored, noise, np.random.default_rng([seed, number, round(noise)]))
            for method, make in METHODS.items():
                reported = listen(make, explored, sensed)
                (barely if kind == BARELY else counts)[method, noise].take(kind, explored, reported)
    return counts, barely


def _rows(
    counts: Mapping[tuple[str, float], _Count], way: Callable[[_Count], Iterator[dict[str, Any]]]
) -> list[dict[str, Any]]:
    return [{"method": m, "noise": n} | row for (m, n), count in counts.items() for row in way(count)]


def _level(count: _Count) -> Iterator[dict[str, Any]]:
    yield {
        "right": sum(count.right.values()) / sum(count.ticks.values()),
        "true_switches": count.number["true switches"],
        "switches": count.number["switches"],
        "wrong_switches": count.number["wrong switches"],
        "longest_wrong_run": count.longest_run,
        "contacts_within_5_ms": count.number["soon"] / count.number["contacts"] if count.number["contacts"] else None,
        "contacts_while_the_loop_stood_still": count.number["stood still"],
        "invented_taps": count.number["invented taps"],
    }


def _scenes(count: _Count) -> Iterator[dict[str, Any]]:
    for kind, ticks in count.ticks.items():
        yield {"scene": kind, "seconds": ticks * TICK_S, "right": count.right[kind] / ticks}


def _latencies(count: _Count) -> Iterator[dict[str, Any]]:
    for name, late_s in sorted(count.late_s.items()):
        p5, p50, p95, p99 = np.quantile(late_s, (0.05, 0.5, 0.95, 0.99)).tolist()
        spread = {"p5_s": p5, "p50_s": p50, "p95_s": p95, "p99_s": p99, "most_s": max(late_s)}
        yield {"switch": name, "count": len(late_s), "never": count.never[name]} | spread


def _taps(count: _Count) -> Iterator[dict[str, Any]]:
    true, reported = np.array(count.taps).T
    for low, high in pairwise(SPEEDS_M_S):
        mine = (true >= low) & (true < high)
        if mine.any():
            error = reported[mine] / true[mine] - 1.0
            yield {
                "from_m_s": low,
                "to_m_s": high,
                "count": int(mine.sum()),
                "bias": float(error.mean()),
                "rms": float(np.sqrt((error**2).mean())),
                "p95": float(np.quantile(np.abs(error), 0.95)),
            }
