"""Strategies for a slow plate: cut off what it cannot do, start early, or show less of everything.

Each runs on an ideal plate (`ideal_plate`). It is judged by the error at the simulated finger against the same finger
on the object itself, and by what an observer model can still distinguish.
"""

from collections.abc import Iterator
from functools import cache
from typing import Any

from operator_site.thermal.contact_prediction import LEAD_S
from studies.observer.thermal_comparison import OBJECTS as COMPARED_OBJECTS
from studies.observer.thermal_comparison import PAIRS, USUAL_S
from studies.observer.thermal_observer import answers, cue
from studies.thermal_rendering.felt_error import felt_error
from studies.touches.ideal_plate import ideal_plate_touch
from studies.touches.real_touch import real_touch
from studies.touches.simulated_finger import STEP_S, Array

STRATEGIES: dict[str, dict[str, float]] = {
    "cut off": {},
    f"{LEAD_S:g} s early": {"lead_s": LEAD_S},
    "1 s early": {"lead_s": 1.0},
    "0.4 of the way": {"share": 0.4},
}
RATES = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
"""Rates of a plate, as multiples of a TactTip's."""
OBJECTS = ("copper", "iron", "ceramic_tile", "skin_dermis", "pvc", "pine", "pu_foam")
TEMPERATURES_C = (25.0, 37.0)
SECONDS = 10.0


@cache
def on_object(name: str, object_c: float) -> Array:
    """Change of the felt temperature on the object itself, K."""
    return real_touch(name, object_c, SECONDS)


def strategy_rows() -> Iterator[dict[str, Any]]:
    """Errors of each strategy, and the change that is felt before contact."""
    for name in OBJECTS:
        for object_c in TEMPERATURES_C:
            for strategy, how in STRATEGIES.items():
                felt = ideal_plate_touch(name, object_c, SECONDS, **how)
                error = felt_error(felt, on_object(name, object_c))
                yield {
                    "object": name,
                    "object_c": object_c,
                    "strategy": strategy,
                    "error_k": error.largest_k,
                    "share_of_tolerance": error.share,
                    "twice_the_tolerance_until_s": error.twice_until_s,
                    "early_k": abs(float(felt[0])),
                    "beyond_k": error.beyond_k,
                }


def rate_rows() -> Iterator[dict[str, Any]]:
    """Errors of plates of other rates, which cut off what they cannot do."""
    for name in OBJECTS:
        for times in RATES:
            error = felt_error(
                ideal_plate_touch(name, TEMPERATURES_C[0], SECONDS, faster=times), on_object(name, TEMPERATURES_C[0])
            )
            yield {"object": name, "times_as_fast": times, "error_k": error.largest_k, "at_s": error.at_s}


def colder_rows() -> Iterator[dict[str, Any]]:
    """Share of answers that the first of two objects is colder, on the objects themselves and by each strategy."""
    at, object_c = round(USUAL_S / STEP_S), TEMPERATURES_C[0]
    for pair in PAIRS:
        names = [COMPARED_OBJECTS[letter] for letter in pair.split("-")]
        sides = {"real": [on_object(name, object_c)[at] for name in names]}
        for strategy, how in STRATEGIES.items():
            sides[strategy] = [ideal_plate_touch(name, object_c, USUAL_S, **how)[at] for name in names]
        for side, (first, second) in sides.items():
            shares = answers(cue(float(first)) - cue(float(second)))
            yield {"pair": pair, "shown": side, "colder_percent": 100.0 * shares.colder}
