"""The loop that both sites share, on a clock of the test's own."""

import json
import socket
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from common.faults.fault import Fault, FaultCode
from common.faults.texts import fault_text
from common.runtime.containment import Containment
from common.runtime.realtime_priority import RealtimePriority
from common.runtime.site_loop import in_words, run_site_loop
from common.runtime.systemd_notify import Supervisor
from common.runtime.watchdog import LoopWatchdog
from tests.conftest import Contained

CUT_OUT = fault_text(Fault(FaultCode.MODULE_CUT_OUT))
MS = 1_000_000


class Clock:
    """Time that passes by sleeping, and by what a tick costs."""

    def __init__(self) -> None:
        self.now_ns = 5_000 * MS

    def sleep(self, seconds: float) -> None:
        self.now_ns += round(seconds * 1e9)


class Site:
    """Ticks that are counted; one of them may take long, or fail."""

    def __init__(self, clock: Clock, costs_ms: dict[int, int] | None = None, fails_at: int | None = None) -> None:
        self.ticked_ns: list[int] = []
        self.contain = Containment()
        self._clock = clock
        self._costs_ms = costs_ms or {}
        self._fails_at = fails_at
        self.look: Callable[[], object] = lambda: None

    def tick(self, now_ns: int) -> None:
        self.look()
        self.ticked_ns.append(now_ns)
        self._clock.now_ns += self._costs_ms.get(len(self.ticked_ns), 0) * MS
        if len(self.ticked_ns) == self._fails_at:
            raise RuntimeError("as the test says")

    def figures(self) -> dict[str, object]:
        return {"state": "engaged", "fault": None, "made": len(self.ticked_ns)}


class Heard(Supervisor):
    """Notices that a supervisor received."""

    def __init__(self) -> None:
        super().__init__("")
        self.lines: list[tuple[str, ...]] = []

    def _say(self, *lines: str) -> None:
        self.lines.append(lines)


class Asked(RealtimePriority):
    """Reports of the loop; the system is not changed."""

    def __init__(self) -> None:
        self.seen: list[tuple[bool, float | None]] = []
        super().__init__(take_realtime=lambda: True, take_ordinary=lambda: None)

    def look(self, holds_rate: bool, works: float | None) -> bool:
        self.seen.append((holds_rate, works))
        return super().look(holds_rate, works)


def run(clock: Clock, site: Site, until_ms: int, status: Path | None = None, **more: Any) -> Heard:
    heard = Heard()
    end_ns = clock.now_ns + until_ms * MS
    defaults = {"precedence": Asked(), "watchdog": lambda ticks: nullcontext(), "supervisor": heard}
    run_site_loop(
        site,
        "remote",
        500.0,
        lambda: clock.now_ns >= end_ns,
        status=status,
        clock_ns=lambda: clock.now_ns,
        sleep=clock.sleep,
        **defaults | more,
    )
    return heard


def test_it_ticks_at_its_rate_with_the_clocks_time_which_the_watchdog_sees() -> None:
    clock = Clock()
    site = Site(clock)
    counted: list[int] = []

    def watch(ticks: Callable[[], int]) -> AbstractContextManager[object]:
        site.look = lambda: counted.append(ticks())
        return nullcontext()

    run(clock, site, 1000, watchdog=watch)
    assert len(site.ticked_ns) == 500
    steps_ns = {later - earlier for earlier, later in pairwise(site.ticked_ns)}
    assert all(abs(step_ns - 2 * MS) < 1000 for step_ns in steps_ns)
    assert counted == list(range(1, 501))


@pytest.mark.parametrize("with_status", [False, True])
def test_figures_go_to_status_and_supervisor_once_a_second_and_at_the_end(tmp_path: Path, with_status: bool) -> None:
    clock, status = Clock(), tmp_path / "remote.json"
    site = Site(clock)
    seconds: list[int] = []
    states: list[str] = []

    def look() -> None:
        seconds.append(len(site.ticked_ns))
        if status.exists():
            states.append(json.loads(status.read_text())["state"])

    heard = run(clock, site, 3_500, status if with_status else None, each_second=look)
    assert len(seconds) == 4
    assert seconds[0] == 1, "at once, after the first tick"
    seen = ("WATCHDOG=1", "STATUS=engaged")
    assert heard.lines == [("READY=1",), seen, seen, seen, seen, ("STOPPING=1",)]
    if with_status:
        assert states == ["engaged"] * 3
        last = json.loads(status.read_text("utf-8"))
        assert (last["process"], last["state"]) == ("remote", "ended")
        assert last["made"] == len(site.ticked_ns), "written again at the end"


def test_a_missed_rate_is_reported_everywhere(tmp_path: Path) -> None:
    clock = Clock()
    site = Site(clock, costs_ms=dict.fromkeys(range(10_000), 4))
    seen: list[dict[str, object]] = []
    heard = run(clock, site, 7_000, tmp_path / "remote.json", report=lambda _, figures: seen.append(figures))
    words = json.loads((tmp_path / "remote.json").read_text("utf-8"))["behind"]
    assert words.startswith("250 of 500 ticks a second; it works ")
    assert heard.lines[-2][1].startswith("STATUS=engaged: 250 of 500 ticks a second")
    assert seen[-1]["rate_hz"] == pytest.approx(250.0, abs=1.0)


def test_a_loop_on_time_gets_real_time_priority_and_a_late_loop_does_not(tmp_path: Path) -> None:
    for costs_ms, first in ((0, True), (4, False)):
        clock, asked = Clock(), Asked()
        site = Site(clock, costs_ms=dict.fromkeys(range(10_000), costs_ms))
        seen: list[dict[str, object]] = []
        run(clock, site, 7_000, tmp_path / "remote.json", report=lambda _, each: seen.append(each), precedence=asked)  # noqa: B023
        assert [works is None for _, works in asked.seen] == [True] * 5 + [False] * (len(asked.seen) - 5)
        assert asked.seen[-1][0] == first
        assert not seen[0]["real_time"]
        assert seen[-1]["real_time"] == first
        assert json.loads((tmp_path / "remote.json").read_text("utf-8"))["real_time"] == first


def test_a_loop_that_never_ran_was_never_ready() -> None:
    clock = Clock()
    site = Site(clock)
    heard = run(clock, site, 0)
    assert site.ticked_ns == []
    assert heard.lines == [("STOPPING=1",)]


def test_a_long_tick_is_not_made_up_for_in_a_burst() -> None:
    clock = Clock()
    site = Site(clock, costs_ms={10: 800})
    run(clock, site, 1000)
    after = [now_ns for now_ns in site.ticked_ns if now_ns > site.ticked_ns[9]]
    assert len(after) == 91  # 20 ms, a tick of 800 ms, the one that was due, and 90 on a new grid
    assert min(b - a for a, b in pairwise(after)) > 1.9 * MS


def test_the_supervisor_is_notified_of_an_end_by_error() -> None:
    clock, heard = Clock(), Heard()
    with pytest.raises(RuntimeError, match="as the test says"):
        run(clock, Site(clock, fails_at=3), 1000, supervisor=heard)
    assert heard.lines[-1] == ("STOPPING=1",)


def test_other_exceptions_of_hook_or_figures_are_named_and_the_loop_continues(
    tmp_path: Path, contained: Contained
) -> None:
    clock = Clock()
    site = Site(clock)

    def fail() -> dict[str, object]:
        raise ValueError("a damaged list")

    site.figures = fail  # type: ignore[method-assign]
    heard = run(clock, site, 2500, tmp_path / "status.json", each_second=fail)
    assert len(site.ticked_ns) == 1250
    assert [name.split(":")[0] for name in contained.take()] == ["each second", "figures"]
    assert list(site.contain.places.values()) == [3, 4]
    assert sum("WATCHDOG=1" in line for line in heard.lines) == 3


def test_a_real_supervisor_is_found_in_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    address = str(tmp_path / "notify")
    clock = Clock()
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
        heard.bind(address)
        heard.settimeout(10.0)
        monkeypatch.setenv("NOTIFY_SOCKET", address)
        run(clock, Site(clock), 10, supervisor=None, precedence=None, watchdog=LoopWatchdog)
        assert [heard.recv(1000) for _ in range(3)] == [b"READY=1", b"WATCHDOG=1\nSTATUS=engaged", b"STOPPING=1"]


@pytest.mark.parametrize(
    ("figures", "words"),
    [
        ({"state": "engaged", "fault": None, "missing": ""}, "engaged"),
        ({"state": "fault", "fault": Fault(FaultCode.MODULE_CUT_OUT), "missing": "x"}, f"fault: {CUT_OUT}"),
        ({"state": "disconnected", "missing": "index tacttip: opening"}, "disconnected: index tacttip: opening"),
        ({"state": "engaged", "behind": "400 of 500 ticks a second"}, "engaged: 400 of 500 ticks a second"),
        ({"state": "engaged", "stale": "no touch for 0.30 s"}, "lost: no touch for 0.30 s"),
        ({"state": "disconnected", "stale": "no remote site"}, "disconnected: no remote site"),
        ({}, "running"),
    ],
)
def test_a_state_is_reported_with_its_problem(figures: dict[str, object], words: str) -> None:
    assert in_words(figures) == words
