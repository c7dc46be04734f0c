"""A console that ends is started again by the launcher after pauses that grow, and the session stays."""

import sys
from itertools import pairwise
from pathlib import Path

import pytest

from teletaction.session import processes
from teletaction.session.demo import _restart
from teletaction.session.demo_files import CONSOLE
from teletaction.session.processes import SessionProcesses
from teletaction.session.restarts import FIRST_PAUSE_S, MOST, SETTLED_S, Restarts


def start_again(restarts: Restarts, now_s: float) -> float:
    """Wait for the pause, and start; returns the time then, s."""
    pause_s = restarts.ended(now_s)
    assert pause_s is not None
    now_s += pause_s
    assert restarts.ended(now_s) == pytest.approx(0.0, abs=1e-9)
    restarts.started(now_s)
    return now_s


def test_pauses_grow_until_the_launcher_gives_up() -> None:
    restarts, now_s, times = Restarts(), 100.0, [100.0]
    for _ in range(MOST):
        now_s = start_again(restarts, now_s)
        times.append(now_s)
    pauses = [later - earlier for earlier, later in pairwise(times)]
    assert pauses == pytest.approx([FIRST_PAUSE_S * 2**number for number in range(MOST)])
    assert restarts.ended(now_s + 1.0) is None


def test_a_console_that_ran_for_long_starts_a_new_count() -> None:
    restarts = Restarts()
    now_s = start_again(restarts, start_again(restarts, 100.0))
    assert restarts.count == 2
    assert restarts.ended(now_s + SETTLED_S) == pytest.approx(FIRST_PAUSE_S)
    assert restarts.count == 1


@pytest.fixture
def session(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SessionProcesses:
    """A session whose console ends at once, each time."""
    program = tmp_path / "program"
    program.write_text("#!/bin/sh\necho dying; exit 3\n")
    program.chmod(0o700)
    monkeypatch.setattr(processes.sys, "executable", str(program))  # type: ignore[attr-defined]
    session = SessionProcesses(tmp_path)
    session.start(CONSOLE, tmp_path / "console.toml")
    assert sys.executable == str(program)
    return session


@pytest.mark.long
def test_a_dead_console_is_restarted_and_never_ends_the_session(
    session: SessionProcesses, capsys: pytest.CaptureFixture[str]
) -> None:
    restarts, now_s, pids = Restarts(), 0.0, set[int]()
    while CONSOLE in session.running:
        process = session.running[CONSOLE]
        pids.add(process.pid)
        code = process.wait(10)
        _restart(session, CONSOLE, restarts, code, now_s)
        now_s += 0.05
        assert now_s < 60.0
    assert len(pids) == 1 + MOST
    assert (session.out / f"{CONSOLE}.log").read_text() == "dying\n" * (1 + MOST), "the log of each start is kept"
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "the console ended with exit code 3: dying; it is started again"
    assert len(said) == MOST + 1
    assert "is not started again" in said[-1]
