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
    "teletaction.command_line",
)
"""What a process imports first."""
NUMBERS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
COUNT = """
import common
import scipy.linalg
from threadpoolctl import threadpool_info
print(*(library["num_threads"] for library in threadpool_info()))
"""
"""Prints the threads of each library of linear algebra."""
FIRST_NUMPY = """
import importlib, os, sys

class Numpy:
    def find_spec(self, name, path, target=None):
        if name == "numpy":
            print(root, *(os.environ.get(variable, "unset") for variable in variables.split()), flush=True)
            os._exit(0)

variables, *roots = sys.argv[1:]
for root in roots:
    if not os.fork():
        sys.meta_path.insert(0, Numpy())
        importlib.import_module(root)
        import numpy
    os.wait()
"""
"""Prints what the libraries read when each root, imported first in a process, comes to numpy."""


def output(program: str, *arguments: str, **chosen: str) -> str:
    """What a program prints in a process where `chosen` is set."""
    surroundings = {name: value for name, value in os.environ.items() if name not in NUMBERS} | chosen
    run = (sys.executable, "-c", program, *arguments)
    return subprocess.run(run, env=surroundings, capture_output=True, text=True, check=True).stdout


def test_every_process_sets_one_thread_before_it_loads_numpy() -> None:
    assert output(FIRST_NUMPY, " ".join(NUMBERS), *ROOTS).splitlines() == [f"{root} 1 1 1" for root in ROOTS]


def test_linear_algebra_has_no_threads_of_its_own() -> None:
    assert set(output(COUNT).split()) == {"1"}


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one processor: there is nothing to share out")
def test_requested_threads_are_allowed() -> None:
    assert set(output(COUNT, OPENBLAS_NUM_THREADS="2").split()) == {"2"}
