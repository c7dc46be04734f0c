"""Do not judge real-time tests that fail while the machine stood still, nor costs measured on a busy one.

A process of its own watches the machine. It does nothing but wake up every 2 ms, so that neither a session nor busy
programs beside it make it late. No test is run again; at most two of a run may end without a judgement, and none in
two runs of this folder in a row.
"""

import os
import subprocess
import sys
import time
from collections.abc import Generator, Iterable
from typing import Any

import pytest

from common.runtime.machine import ProcessorTime

STOOD_STILL_S = 0.040
"""The watching process is never so late by the work of a session, nor by four busy loops beside it."""
MOST = 2
"""Of a run; more fail it."""
REAL_TIME = ("session", "faults", "console", "containers", "netns", "costs", "real_time")
"""Marks of tests that depend on the machine's time. `real_time(stall_s=...)` names the standstill that matters."""
ALONE = "alone"
"""Mark of tests that compare costs: they are not judged while others use more than OTHERS processors."""
OTHERS = 0.5
PROTECTS = "protects"
"""Mark of tests of a gate or of an emergency stop, which are always judged."""
NOT_JUDGED = "not judged: "
_CACHED = "not-judged"
"""Names of the tests whose last run here was not judged."""
_LEAST_S = 0.004
_WATCH = """
import select, sys, time
stalls, then_s = [], time.monotonic()
while True:
    asked = bool(select.select([sys.stdin], [], [], 0.002)[0])
    now_s = time.monotonic()
    if now_s - then_s > float(sys.argv[1]):
        stalls.append((then_s, now_s))
    then_s = now_s
    if asked:
        if not sys.stdin.readline():
            break
        for stall in stalls:
            print(*stall)
        stalls.clear()
        print("now", flush=True)
"""


class Watch:
    """A process that notes when the machine stood still.

    Attributes:
        process: it.
    """

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", _WATCH, str(_LEAST_S)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._stalls: list[tuple[float, float]] = []
        self.longest_s(0.0)

    def longest_s(self, since_s: float) -> float:
        """The longest standstill since a time of the monotonic clock, s."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        while (line := self.process.stdout.readline()) not in ("now\n", ""):
            begun_s, ended_s = map(float, line.split())
            self._stalls.append((begun_s, ended_s))
        return max((ended_s - begun_s for begun_s, ended_s in self._stalls if ended_s > since_s), default=0.0)

    def end(self) -> None:
        """End the process."""
        self.process.communicate()


class Others:
    """Processors that other programs use, from now on: all that is busy, less this process and its ended children."""

    def __init__(self) -> None:
        self._begun_s, self._machine, self._own_s = time.monotonic(), ProcessorTime.now(), self._used_s()

    @staticmethod
    def _used_s() -> float:
        times = os.times()
        return times.user + times.system + times.children_user + times.children_system

    def used(self) -> float:
        """Processors, on average; time that other virtual machines took counts as well."""
        now = ProcessorTime.now()
        busy = now.total - self._machine.total - (now.idle - self._machine.idle)
        busy_s = busy / os.sysconf("SC_CLK_TCK")
        return (busy_s - (self._used_s() - self._own_s)) / (time.monotonic() - self._begun_s)


class NotJudged:
    """The plugin.

    Attributes:
        watch: of the machine; None while no test depends on its time.
        found: what was not judged, by the names of tests.
        again: those of them that their run before did not judge either.
    """

    def __init__(self) -> None:
        self.watch: Watch | None = None
        self.found: dict[str, str] = {}
        self.again: set[str] = set()
        self._judged: set[str] = set()
        self._begun_s: dict[str, float] = {}
        self._others: dict[str, Others] = {}

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Watch, where a test depends on the machine's time."""
        if not session.config.option.collectonly and any(_stall_s(item) is not None for item in session.items):
            self.watch = Watch()

    def pytest_unconfigure(self) -> None:
        """Watch no longer."""
        if self.watch is not None:
            self.watch.end()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Note when a test begins."""
        self._begun_s[item.nodeid] = time.monotonic()
        if item.get_closest_marker(ALONE) is not None and item.get_closest_marker(PROTECTS) is None:
            self._others[item.nodeid] = Others()

    @pytest.hookimpl(tryfirst=True)
    def pytest_fixture_setup(self, fixturedef: pytest.FixtureDef[Any], request: pytest.FixtureRequest) -> None:
        """Note when what several tests of a module judge began."""
        if fixturedef.scope == "module":
            self._begun_s[f"{request.node.nodeid}: {fixturedef.argname}"] = time.monotonic()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Judge a test that failed, or do not."""
        report = yield
        if report.failed and report.when != "teardown" and (excuse := self._excuse(item)):
            report.outcome = "skipped"
            report.longrepr = (str(item.path), item.location[1] or 0, f"{NOT_JUDGED}{excuse}")
        return report

    def _excuse(self, item: pytest.Item) -> str:
        """Return what the machine did to a test that failed; empty where that is no excuse."""
        stall_s = _stall_s(item)
        if stall_s is not None and self.watch is not None:
            longest_s = self.watch.longest_s(min(self._beginnings(item)))
            if longest_s > stall_s:
                return f"the machine stood still for {longest_s * 1e3:.0f} ms"
        others = self._others.get(item.nodeid)
        used = others.used() if others is not None else 0.0
        return f"other programs used {used:.1f} processors" if used > OTHERS else ""

    def _beginnings(self, item: pytest.Item) -> Iterable[float]:
        yield self._begun_s[item.nodeid]
        module = item.getparent(pytest.Module)
        for name in getattr(item, "fixturenames", ()):
            begun_s = self._begun_s.get(f"{module.nodeid}: {name}") if module else None
            if begun_s is not None:
                yield begun_s

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count; with several processes this is called in the one that has the result."""
        if report.skipped and isinstance(report.longrepr, tuple) and report.longrepr[2].startswith(NOT_JUDGED):
            self.found[report.nodeid] = report.longrepr[2]
        elif report.when == "call" or report.failed:
            self._judged.add(report.nodeid)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Fail a run of which too much was not judged, or a test that was not judged twice."""
        here = not hasattr(session.config, "workerinput")
        cache: pytest.Cache | None = getattr(session.config, "cache", None) if here else None
        if cache is not None:
            before = set(cache.get(_CACHED, []))
            self.again = before & self.found.keys()
            cache.set(_CACHED, sorted((before - self._judged) | self.found.keys()))
        if len(self.found) > MOST or self.again:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Name what was not judged."""
        for name, reason in self.found.items():
            terminalreporter.write_line(f"NOT JUDGED {name} - {reason.removeprefix(NOT_JUDGED)}")
        if len(self.found) > MOST:
            terminalreporter.write_line(f"FAILED {len(self.found)} tests were not judged; {MOST} may be")
        for name in sorted(self.again):
            terminalreporter.write_line(f"FAILED {name} - not judged in two runs")


def _stall_s(item: pytest.Item) -> float | None:
    """The standstill that excuses a test, s; None where nothing does."""
    if item.get_closest_marker(PROTECTS) is not None:
        return None
    if mark := item.get_closest_marker("real_time"):
        return float(mark.kwargs.get("stall_s", STOOD_STILL_S))
    return STOOD_STILL_S if any(item.get_closest_marker(name) for name in REAL_TIME) else None
