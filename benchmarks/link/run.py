"""The link: latency and processor time beside bare sockets, age of rendered data on bad networks, safe states.

The figure also shows where the method fails: the networks on which the session is in its safe state.
"""

import os
import platform
from typing import Any

import zmq

from benchmarks.link.age import sweep
from benchmarks.link.faults import DEFAULT_FAULTS, safe_state_times
from benchmarks.link.latency import LINK
from benchmarks.link.latency import measure as measure_latency
from benchmarks.link.load import compare, ratios, scale
from benchmarks.link.packets import size_table
from studies.compared import Compared
from studies.pieces import HERE, Work, part_of
from studies.running import Progress

_RATES_HZ = (100.0, 200.0, 500.0, 1000.0)
_NETWORK = ("sent", "delay_ms", "jitter_ms", "loss_percent", "max_age_ms")
COMPARED = (
    Compared("latency.ways", "to_bare", "less", ("way",), {"way": LINK}, relative=0.2),
    Compared("cpu", "link_to_bare", "less", relative=0.2),
    Compared("age", "safe_state_share", "less", _NETWORK, absolute=0.05),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Measure everything; measurements of this machine run by themselves.

    Findings of the fault matrix are left out, with a note, when their file is missing.

    Args:
        quick: a minute and a quarter with coarse grids, instead of some ten minutes.
        seed: seed of the order of the ways, and of the networks.
        work: runs the pieces that are on virtual time: the age.

    Raises:
        EndLost: a process of a measurement ended.
    """
    safe_states = safe_state_times(DEFAULT_FAULTS)
    latency = measure_latency(25 if quick else 200, seed, part_of(progress, 0.0, 0.15))
    cpu = compare(2 if quick else 6, 1.5 if quick else 4.0, part_of(progress, 0.15, 0.4))
    scaling = scale(quick, 1.0 if quick else 4.0, part_of(progress, 0.4, 0.7))
    age = work(sweep(quick, seed), part_of(progress, 0.7, 1.0))
    return {
        "machine": {
            "processors": os.cpu_count(),
            "python": platform.python_version(),
            "zmq": zmq.zmq_version(),
            "pyzmq": zmq.pyzmq_version(),
        },
        "latency": latency,
        "cpu": {"measurements": cpu, **ratios(cpu)},
        "scaling": scaling,
        "bytes": size_table(_RATES_HZ),
        "age": [row for rows in age for row in rows],
        "safe_states": safe_states,
    }


def tables(data: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """Tables of the result, by name."""
    return {
        "latency": data["latency"]["ways"],
        "cpu": data["cpu"]["measurements"],
        "scaling": data["scaling"],
        "bytes": data["bytes"],
        "age": data["age"],
    }
