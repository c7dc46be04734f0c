"""A fixed piece of work of about 0.1 ms: a unit of processor cost that does not depend on the machine's speed.

Half of it is scalar Python on small objects, half of it numpy on small arrays, as in a tick of a site.
"""

import time
from dataclasses import dataclass

import numpy as np

_ROUNDS = 18
_SYSTEMS = 26
_MATRICES = np.linspace(1.0, 2.0, _SYSTEMS * 36).reshape(_SYSTEMS, 6, 6) + 6.0 * np.eye(6)
_OTHER_BYTES = 2**25
"""Size of an array larger than the caches of a processor core, bytes."""
_TIMES = 30
_SAMPLES = np.linspace(-1.0, 1.0, 200)


@dataclass(slots=True)
class _Place:
    x_m: float
    y_m: float
    age_s: float


def reference_step() -> float:
    """Do the work; return a result that depends on all of it."""
    found = 0.0
    places: dict[str, _Place] = {}
    for number in range(_ROUNDS):
        place = _Place(0.1 * number, 0.2 * number, 0.001)
        places[f"finger {number % 5}"] = place
        found += min(max(place.x_m - place.y_m, -1.0), 1.0) * place.age_s
    for number in range(4):
        window = _SAMPLES[number : number + 180]
        found += float(np.dot(window, window)) + float(np.abs(window).max())
    solved: np.ndarray = np.linalg.solve(_MATRICES, np.ones((_SYSTEMS, 6, 1)))
    return found + float(solved[0, 0, 0]) + sum(place.x_m for place in places.values())


def reference_step_s() -> float:
    """Return the processor time of one reference step on this machine, s: the median of _TIMES.

    Caches are cold, as in a tick after a pause and the work of other processes. With warm caches a step is up to three
    times as fast, and differs more between machines than sessions do.
    """
    other = np.zeros(_OTHER_BYTES // 8)
    spent = []
    for _ in range(_TIMES):
        other += 1.0
        begun_ns = time.thread_time_ns()
        reference_step()
        spent.append(time.thread_time_ns() - begun_ns)
    return float(np.median(spent)) * 1e-9
