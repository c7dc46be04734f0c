"""Cost of consoles: lateness of the operator's loop without a console, with an unwatched one, and with five pages.

The study runs real processes on this machine: simulated devices, an operator site on a virtual environment, a console,
and pages that take and confirm every picture. The ways take turns in one session, in another order each turn. Other
load on the machine and the after-effects of one way thus fall on all of them. Each turn measures twice without a
console. The difference of these two is the noise floor of the measurement. After the turns the pages stay open for
minutes while the console's memory is recorded. If the loop has real-time priority, it then takes further turns with
ordinary priority: twice without a console, and with five pages.
"""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.config.file import load_config, to_toml
from common.config.site_models import OperatorConfig
from common.runtime.scheduling import policy, take_ordinary
from robustness.fault_session import read_figures
from robustness.soak_growth import lives
from robustness.soak_watch import Sample, sample
from studies.compared import Compared
from studies.running import Progress, Unavailable
from teletaction.recordings.recorded_session import RecordedSession
from teletaction.session.demo_files import CONSOLE, DemoOptions, prepare
from teletaction.session.processes import SessionProcesses, die_with_parent

MEASURES_THIS_MACHINE = "how late loops are on this machine"
NONE, AGAIN, UNSEEN, SEEN = "no console", "no console, again", "a console, no page", "five pages"
WAYS = (NONE, AGAIN, UNSEEN, SEEN)
ORDINARY_WAYS = NONE_ORDINARY, AGAIN_ORDINARY, SEEN_ORDINARY = (
    "no console, ordinary loop",
    "no console, ordinary loop, again",
    "five pages, ordinary loop",
)
"""Ways in which the loop's thread has ordinary priority, as on a machine that allows no real-time priority."""
_ALONE, _LOOKED_AT = (NONE, AGAIN, NONE_ORDINARY, AGAIN_ORDINARY), (SEEN, SEEN_ORDINARY)
_WITHOUT = {AGAIN: NONE, UNSEEN: NONE, SEEN: NONE, AGAIN_ORDINARY: NONE_ORDINARY, SEEN_ORDINARY: NONE_ORDINARY}
"""Baseline without a console of each way."""
PAGES = 5
CPU_GOAL = 0.30
"""Share of one core below which the cost of a page for the console must stay."""
TURN_S, TURNS, WATCHED_S = 6.0, 12, 600.0
QUICK_TURN_S, QUICK_TURNS, QUICK_WATCHED_S = 3.0, 1, 15.0
_SETTLE_S = 2.0
"""Time before a measurement, s: a new process still loads, and a new page first gets the whole picture."""
_START_S = 30.0
_ACCOUNTED = ("virtual", CONSOLE, "pages", "sim-operator")
_QUANTILES = (0.5, 0.9, 0.99, 0.999)
Row = dict[str, float]
COMPARED = (Compared("", "core_per_page", "less", absolute=0.05),)


def run(*, quick: bool, seed: int, progress: Progress) -> dict[str, Any]:
    """Measure the ways in turns, then the console's memory.

    Raises:
        Unavailable: the dependencies of the console are not installed.
    """
    if find_spec("starlette") is None:
        raise Unavailable("the console is not installed: pip install 'teletaction[console]'")
    if quick:
        return measure(QUICK_TURN_S, QUICK_TURNS, QUICK_WATCHED_S, seed, progress)
    return measure(TURN_S, TURNS, WATCHED_S, seed, progress)


def measure(turn_s: float, turns: int, watched_s: float, seed: int, progress: Progress) -> dict[str, Any]:
    """Measure each way for `turn_s`, `turns` times, and record memory for `watched_s` (at least 15 s)."""
    with TemporaryDirectory(prefix="consoles-") as spare:
        session = Watched(Path(spare), seed)
        with session.running():
            session.take_turns(WAYS, turns, turn_s, progress)
            progress(f"five pages for {watched_s:.0f} s")
            memory = session.watch(watched_s)
            if session.has_real_time():
                session.take_turns(ORDINARY_WAYS, turns, turn_s, progress)
            else:
                progress("the loop has no real-time priority here: everything was measured with ordinary priority")
        judged = session.judged()
        return judged | memory | {"problems": judged["problems"] + memory["memory"]["wrong"]}


def tables(data: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """One table, with a row for each way."""
    return {"ways": [{"way": way} | row for way, row in data["ways"].items()]}


class Interval(NamedTuple):
    """A measured interval: its way, begin and end on the monotonic clock, s, processor time of each process, s, and
    whether the loop had real-time priority at its end."""

    way: str
    begin_s: float
    end_s: float
    used_s: dict[str, float]
    real_time: bool


class Watched:
    """One session, and its measured intervals."""

    def __init__(self, folder: Path, seed: int):
        self._folder = folder
        self._intervals: list[Interval] = []
        self._pages: list[dict[str, int]] = []
        self._configurations = prepare(
            DemoOptions(seconds=3600.0, fingers=5, scene="phantom_sweep", seed=seed, console=True), folder
        )
        # No presence is required, so that the session is the same with a console and without.
        operator = self._configurations["operator"]
        changed = load_config(operator, OperatorConfig).model_copy(update={"engage": True, "console_required_s": 0.0})
        operator.write_text(to_toml(changed), "utf-8")
        self._processes = SessionProcesses(folder)
        self._seed = seed

    @contextmanager
    def running(self) -> Iterator[None]:
        """Run the site and its devices; end them on exit."""
        self._processes.start("sim-operator", self._configurations["sim-operator"])
        environment = ("--scene", "phantom_sweep", "--seed", str(self._seed))
        self._processes.start("virtual", self._configurations["operator"], *environment)
        try:
            self._wait("operator", lambda figures: figures.get("state") == "engaged")
            self._wait("operator", lambda figures: figures.get("works") is not None)  # its priority is set by now
            yield
        finally:
            self._processes.end()

    def take_turns(self, ways: Sequence[str], turns: int, seconds: float, progress: Progress) -> None:
        """Measure each of the ways for `seconds`, `turns` times, in changing order."""
        for turn, ordered in enumerate(islice(orders(ways), turns), 1):
            progress(f"turn {turn} of {turns}")
            for way in ordered:
                with ExitStack() as there:
                    if way not in _ALONE:
                        address = there.enter_context(self._console())
                        if way in _LOOKED_AT:
                            there.enter_context(self._looking(address))
                    if way in ORDINARY_WAYS:
                        take_ordinary(self._loop())  # until the loop was late and is on time again
                    time.sleep(_SETTLE_S)
                    self._measure(way, seconds)

    def has_real_time(self) -> bool:
        """Whether the loop's thread has real-time priority."""
        return policy(self._loop()) == os.SCHED_RR

    def _loop(self) -> int:
        return self._processes.running["virtual"].pid  # a process's first thread has its number

    def watch(self, seconds: float) -> dict[str, Any]:
        """Open five pages for `seconds`, and record the console's memory."""
        samples: list[Sample] = []
        with self._console() as address, self._looking(address):
            end_s = time.monotonic() + seconds
            while time.monotonic() < end_s:
                if (found := sample(self._folder, CONSOLE)) is not None:
                    samples.append(found)
                time.sleep(1.0)
        life = lives(samples)[0]
        pages = self._pages[-PAGES:]
        return {
            "memory": life.growth(),
            "watched_s": seconds,
            "memory_curve": {"time_s": (life.time_s - life.time_s[0]).tolist(), "rss_mib": life.rss_mib.tolist()},
            "page": {
                "pictures_per_s": [round(page.get("pictures", 0) / seconds, 1) for page in pages],
                "kilobytes_per_s": [round(page.get("bytes", 0) / seconds * 1e-3, 1) for page in pages],
            },
        }

    def judged(self) -> dict[str, Any]:
        """Results of all intervals. Call it after the session has ended, when its recording is whole."""
        times_s = _tick_times_s(self._folder / "operator.mcap")
        period_s = read_figures(self._folder, "operator")["loop"]["period_ms"] * 1e-3
        ways: dict[str, Any] = {}
        late: dict[str, Any] = {}
        turns: dict[str, list[Row]] = {}
        for way in dict.fromkeys(each.way for each in self._intervals):
            mine = [each for each in self._intervals if each.way == way]
            apart = [np.diff(times_s[(each.begin_s < times_s) & (times_s < each.end_s)]) for each in mine]
            turns[way] = [lateness(ticks_s, period_s) for ticks_s in apart]
            all_s = np.concatenate(apart)
            off_us = np.abs(all_s - period_s) * 1e6
            late[way] = [round(float(value), 1) for value in np.quantile(off_us, np.linspace(0.0, 1.0, 201))]
            seconds = sum(each.end_s - each.begin_s for each in mine)
            used = {name: sum(each.used_s.get(name, 0.0) for each in mine) / seconds for name in _ACCOUNTED}
            ways[way] = {
                "ticks": len(all_s),
                "real_time_share": round(sum(each.real_time for each in mine) / len(mine), 3),
                **lateness(all_s, period_s),
                **{f"{name}_core": round(used[name], 3) for name in _ACCOUNTED},
            }
        a_page = (ways[SEEN]["console_core"] - ways[UNSEEN]["console_core"]) / PAGES
        with_all = ways[SEEN]["console_core"] / PAGES
        problems = [] if with_all < CPU_GOAL else [f"a page costs {with_all:.2f} of a core, wanted {CPU_GOAL}"]
        return {
            "period_ms": period_s * 1e3,
            "ways": ways,
            "turns": turns,
            "more_than_without": {
                way: more_than(turns[way], turns[other]) for way, other in _WITHOUT.items() if way in turns
            },
            "off_us": late,
            "core_per_page": round(a_page, 3),
            "core_per_page_with_its_share": round(with_all, 3),
            "problems": problems,
        }

    def _measure(self, way: str, seconds: float) -> None:
        begin_s, before = time.monotonic(), self._used()
        time.sleep(seconds)
        used = {name: value - before.get(name, 0.0) for name, value in self._used().items()}
        self._intervals.append(Interval(way, begin_s, time.monotonic(), used, self.has_real_time()))

    def _used(self) -> dict[str, float]:
        """Processor time of each process so far, s."""
        return {name: used[0] for name, used in self._processes.usage().items()}

    @contextmanager
    def _console(self) -> Iterator[str]:
        """Run a new console; yields its address."""
        for name in (f"{CONSOLE}.json", f"{CONSOLE}.mcap"):
            (self._folder / name).unlink(missing_ok=True)
        self._processes.start(CONSOLE, self._configurations[CONSOLE])
        process = self._processes.running[CONSOLE]
        try:
            yield str(self._wait(CONSOLE, lambda figures: figures.get("address"))["address"])
        finally:
            process.send_signal(signal.SIGTERM)
            process.wait()
            del self._processes.running[CONSOLE]

    @contextmanager
    def _looking(self, address: str) -> Iterator[None]:
        pages = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.consoles.pages", address, str(PAGES)],
            stdout=subprocess.PIPE,
            preexec_fn=die_with_parent,  # noqa: PLW1509 - the study has no other thread
        )
        try:
            self._wait(CONSOLE, lambda figures: figures.get("clients") == PAGES)
            self._processes.running["pages"] = pages
            yield
        finally:
            self._processes.running.pop("pages", None)
            pages.send_signal(signal.SIGTERM)
            printed, _ = pages.communicate()
        self._pages += json.loads(printed)

    def _wait(self, process: str, ready: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
        """Wait until the status of a process satisfies `ready`; raises TimeoutError."""
        end_s = time.monotonic() + _START_S
        while not ready(figures := read_figures(self._folder, process)):
            for name in self._processes.ended():
                raise TimeoutError(f"{name} has ended: {self._processes.last_words(name)}")
            if time.monotonic() > end_s:
                raise TimeoutError(f"{process} is not ready after {_START_S:g} s: {figures}")
            time.sleep(0.05)
        return figures


def orders(ways: Sequence[str]) -> Iterator[Sequence[str]]:
    """Endless sequence of orders of the ways: in 2 n turns of n ways, each way takes each place twice."""
    while True:
        for first in range(len(ways)):
            order = [*ways[first:], *ways[:first]]
            yield order
            yield order[::-1]


def lateness(apart_s: NDArray[np.float64], period_s: float) -> Row:
    """Quantiles of the period error of ticks `apart_s` apart, us, and the share of missed ticks, %."""
    off_us = np.abs(apart_s - period_s) * 1e6
    return {
        **{f"off_p{100 * q:g}_us": round(float(np.quantile(off_us, q)), 1) for q in _QUANTILES},
        "missed_percent": round(100.0 * float(np.mean(apart_s > 2.0 * period_s)), 3),
    }


def more_than(turns: Sequence[Mapping[str, float]], others: Sequence[Mapping[str, float]]) -> dict[str, Row]:
    """Excess of each figure over the same turn of the other way: median, least, most, and number of positive turns.

    A real effect has the same sign in nearly all turns. By chance, ten or more of twelve turns agree once in 26 times.
    """
    found = {}
    for name in turns[0]:
        more = np.array([turn[name] - other[name] for turn, other in zip(turns, others, strict=True)])
        values = {"median": np.median(more), "least": more.min(), "most": more.max(), "turns": np.sum(more > 0.0)}
        found[name] = {which: round(float(value), 3) for which, value in values.items()}
    return found


def _tick_times_s(recording: Path) -> NDArray[np.float64]:
    """Start of each tick of the loop on the monotonic clock, s."""
    with recording.open("rb") as file:
        session = RecordedSession(recording, file)
        return np.array([time_ns for _, _, time_ns, _ in session.messages(("operator/input",))]) * 1e-9
