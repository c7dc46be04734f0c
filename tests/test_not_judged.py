"""A few failures beside a standstill of the machine are not judged; all others are failures."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.not_judged import MOST

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
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-c", "/dev/null", "--rootdir", folder]
    done = subprocess.run(
        [*words, *options, folder], cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout


@pytest.mark.parametrize("options", [(), ("-n", "1")], ids=["in one process", "shared"])
def test_only_a_failure_beside_a_standstill_is_not_judged(tmp_path: Path, options: tuple[str, ...]) -> None:
    code, said = run(
        tmp_path,
        """
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
""",
        *options,
    )
    assert code == 1
    assert "3 failed, 1 passed, 1 skipped" in said
    (line,) = (line for line in said.splitlines() if line.startswith("NOT JUDGED"))
    assert "::test_disturbed - the machine stood still for " in line


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


def test_many_unjudged_tests_fail_the_run(tmp_path: Path) -> None:
    tests = "".join(f"\n@pytest.mark.session\ndef test_{n}(still):\n    assert False\n" for n in range(MOST + 1))
    code, said = run(tmp_path, tests)
    assert code == 1
    assert f"{MOST + 1} skipped" in said


def test_a_test_may_set_the_standstill_that_excuses_it(tmp_path: Path) -> None:
    code, said = run(
        tmp_path,
        """
@pytest.mark.real_time(stall_s=1.0)
def test_slow(still):
    assert False

@pytest.mark.real_time(stall_s=0.01)
def test_quick(still):
    assert False
""",
    )
    assert code == 1
    assert "1 failed, 1 skipped" in said


def test_costs_are_not_judged_beside_busy_programs(tmp_path: Path) -> None:
    busy = "busy = subprocess.Popen([sys.executable, '-c', 'while True: pass'])"
    code, said = run(
        tmp_path,
        f"""
import subprocess, sys

def compare(beside):
    if beside:
        {busy}
    time.sleep(1.0)
    if beside:
        busy.kill()
    assert False

@pytest.mark.alone
def test_beside(): compare(True)

@pytest.mark.alone
@pytest.mark.protects
def test_of_a_stop_is_judged():
    assert False

def test_of_something_else(): compare(True)
""",
    )
    assert code == 1
    assert "2 failed, 1 skipped" in said
    assert "test_beside - other programs used " in said
