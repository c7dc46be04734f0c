"""The cost of a session's processes includes their child processes."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from teletaction.session.processes import SessionProcesses, family

PARENT = """
import subprocess, sys
child = subprocess.Popen([sys.executable, "-c", "x = bytearray(50_000_000); print(1, flush=True); input()"], stdin=-1)
sys.stdin.readline()
child.communicate(b"\\n")
"""


@pytest.fixture
def parent() -> Iterator["subprocess.Popen[bytes]"]:
    with subprocess.Popen([sys.executable, "-c", PARENT], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()  # of the child: it has what it wants
        yield process
        end(process)


def end(process: "subprocess.Popen[bytes]") -> None:
    assert process.stdin is not None
    process.stdin.close()
    process.wait()


def test_a_process_is_accounted_for_with_those_that_it_started(parent: "subprocess.Popen[bytes]") -> None:
    first, *started = family(parent.pid)
    assert (first, len(started)) == (parent.pid, 1)
    (used,) = SessionProcesses(Path(), {"site": parent}).usage().values()
    assert used[1] > 2 * 5.0 + 47.0, "MiB of two interpreters and of what the child holds"


def test_an_ended_process_costs_nothing(parent: "subprocess.Popen[bytes]") -> None:
    end(parent)
    assert family(parent.pid) == [parent.pid]
    assert SessionProcesses(Path(), {"site": parent}).usage() == {}
