"""In every process of a session, linear algebra runs in the calling thread."""

import os
import subprocess
import sys

import pytest

ROOTS = (
    "common.process",
    "operator_site.console.run",
    "operator_site.site",
    "remote_site.site",
    "sim_sensors.remote_devices",
    "studies.pieces",
    "teletaction.cli",
)
"""What a process imports first."""
NUMBERS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
LOOK = """
import importlib, sys
importlib.import_module(sys.argv[1])
import scipy.linalg
from threadpoolctl import threadpool_info
print(*(library["num_threads"] for library in threadpool_info()))
"""


def threads(root: str, **chosen: str) -> set[int]:
    """Of each library of linear algebra, after importing `root` in a process where `chosen` is set."""
    surroundings = {name: value for name, value in os.environ.items() if name not in NUMBERS} | chosen
    run = (sys.executable, "-c", LOOK, root)
    said = subprocess.run(run, env=surroundings, capture_output=True, text=True, check=True).stdout
    return {int(count) for count in said.split()}


@pytest.mark.parametrize("root", ROOTS)
def test_linear_algebra_has_no_threads_of_its_own(root: str) -> None:
    assert threads(root) == {1}


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one processor: there is nothing to share out")
def test_requested_threads_are_allowed() -> None:
    assert threads("common.process", OPENBLAS_NUM_THREADS="2") == {2}
