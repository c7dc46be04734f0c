"""A few failures beside a standstill of the machine are not judged; all others are failures."""

import select
import subprocess
import sys
from pathlib import Path

import pytest

from tests import not_judged
from tests.not_judged import MOST, Watch

INNER = """
import os, signal, time
import pytest
from tests.not_judged import NotJudged, STOOD_STILL_S

def stand_still(request):
    watch = request.config.pluginmanager.get_plugin("not-judged").watch
    process = watch.process
    process.send_signal(signal.SIGSTOP)
    os.waitpid(process.pid, os.WUNTRACED)
    time.sleep(2.0 * STOOD_STILL_S)
    process.send_signal(signal.SIGCONT)
    watch.longest_s(0.0)  # once it answers, it runs

@pytest.fixture
def still(request):
    stand_still(request)

@pytest.fixture(scope="module")
def story(request):
    stand_still(request)
    return "bad"
"""
CONFTEST = """
from tests.not_judged import NotJudged

def pytest_configure(config):
    for mark in ("session", "protects", "real_time", "alone"):
        config.addinivalue_line("markers", mark + ": of the outer run")
    config.pluginmanager.register(NotJudged(), "not-judged")
"""


def run(folder: Path, tests: str, *options: str) -> tuple[int, str]:
    (folder / "conftest.py").write_text(CONFTEST, "utf-8")
    (folder / "test_inner.py").write_text(INNER + tests, "utf-8")
    words = [sys.executable, "-m", "pytest", "-q", "-c", "/dev/null", "--rootdir", folder]
    done = subprocess.run(
        [*words, *options, folder], cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout


MIXED = """
import subprocess, sys

@pytest.mark.session
def test_disturbed(still):
    assert False

@pytest.mark.session
def test_disturbed_but_fine(still):
    pass

@pytest.mark.session
def test_in_peace():
    assert False

@pytest.mark.session
@pytest.mark.protects
def test_of_a_stop(still):
    assert False

def test_without_a_clock(still):
    assert False

@pytest.mark.real_time(stall_s=1.0)
def test_slow(still):
    assert False

@pytest.mark.real_time(stall_s=0.01)
def test_quick(still):
    assert False

def compare_beside_a_busy_program():
    busy = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    time.sleep(0.4)
    busy.kill()
    assert False

@pytest.mark.alone
def test_costs():
    compare_beside_a_busy_program()

@pytest.mark.alone
@pytest.mark.protects
def test_costs_of_a_stop():
    assert False

def test_of_something_else():
    compare_beside_a_busy_program()
"""
STOOD_STILL = "the machine stood still for "
NOT_JUDGED = {"test_disturbed": STOOD_STILL, "test_quick": STOOD_STILL, "test_costs": "other programs used "}
"""Of MIXED, with the beginning of the reason."""


@pytest.mark.long
def test_only_a_failure_that_the_machine_may_have_made_is_not_judged(tmp_path: Path) -> None:
    """Shared among processes, as the tests of sessions run; those below run in one process."""
    code, said = run(tmp_path, MIXED, "-n", "1")
    assert code == 1
    assert f"6 failed, 1 passed, {len(NOT_JUDGED)} skipped" in said
    lines = [line.partition("::")[2] for line in said.splitlines() if line.startswith("NOT JUDGED")]
    assert len(lines) == len(NOT_JUDGED)
    for name, reason in NOT_JUDGED.items():
        assert any(line.startswith(f"{name} - {reason}") for line in lines), lines


@pytest.mark.long
def test_a_shared_fixture_counts_for_each_of_its_tests(tmp_path: Path) -> None:
    code, said = run(
        tmp_path,
        """
@pytest.mark.session
def test_the_first(story):
    assert story == "good"

@pytest.mark.session
def test_the_second(story):
    assert story == "good"

@pytest.mark.session
def test_another(request):
    pass
""",
    )
    assert code == 0
    assert "1 passed, 2 skipped" in said


@pytest.mark.long
def test_many_unjudged_tests_fail_the_run(tmp_path: Path) -> None:
    tests = "".join(f"\n@pytest.mark.session\ndef test_{n}(still):\n    assert False\n" for n in range(MOST + 1))
    code, said = run(tmp_path, tests)
    assert code == 1
    assert f"{MOST + 1} skipped" in said


TWO = """
@pytest.mark.session
def test_disturbed(still):
    assert {good}

@pytest.mark.session
def test_of_something_else():
    pass
"""


@pytest.mark.long
def test_a_test_that_is_not_judged_in_two_runs_fails(tmp_path: Path) -> None:
    """A run without it between the two changes nothing; a run that judges it does."""
    bad, good = TWO.format(good=False), TWO.format(good=True)
    assert run(tmp_path, bad)[0] == 0
    assert run(tmp_path, bad, "-k", "something")[0] == 0
    code, said = run(tmp_path, bad, "-n", "1")
    assert code == 1
    assert "test_inner.py::test_disturbed - not judged in two runs" in said
    assert run(tmp_path, good)[0] == 0
    assert run(tmp_path, bad)[0] == 0


def test_the_watch_keeps_what_it_notes_until_it_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """A watch that writes at once waits for its reader when the pipe is full, and takes this for a standstill."""
    monkeypatch.setattr(not_judged, "_LEAST_S", 0.0)  # each wake-up is noted
    watch = Watch()
    try:
        assert watch.process.stdout is not None
        assert select.select([watch.process.stdout], [], [], 2.0)[0] == []
        assert watch.longest_s(0.0) > 0.0
    finally:
        watch.end()
