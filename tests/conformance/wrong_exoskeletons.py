"""Emulated exoskeletons with one thing wrong each, by the number of the duty that they break."""

from collections.abc import Callable

import numpy as np

from common.fingers import FINGERS
from tests.conformance.spoiled_module import over
from tests.conformance.spoiled_node import (
    EXO,
    HANGS_ON,
    WrongNodes,
    changed_states,
    exoskeleton,
)
from tests.conformance.virtual_ends import VirtualNode


def crossed_fingers() -> VirtualNode:
    return changed_states(
        exoskeleton(),
        "ExoskeletonState",
        lambda values, _: {**values, "index": values["ring"], "ring": values["index"]},
    )


def enabled_or_not() -> VirtualNode:
    end = exoskeleton()

    def obey(below: Callable[..., None], name: str, values: dict[str, float], now_s: float) -> None:
        below(name, values, now_s)
        end.node._force_n = np.array([values[finger] for finger in FINGERS])

    over(end.node, "_obey", obey)
    return end


def lets_go_slowly() -> VirtualNode:
    left = 0

    def linger(values: dict[str, float], _: int) -> dict[str, float]:
        nonlocal left
        left = HANGS_ON if values["thumb"] > 0.0 else left - 1
        return {**values, "thumb": max(values["thumb"], 0.02)} if left > 0 else values

    return changed_states(exoskeleton(), "ExoskeletonState", linger)


WRONG_EXOSKELETONS: WrongNodes = [
    ("E1", EXO, crossed_fingers),
    ("E2", EXO, enabled_or_not),
    ("E3", EXO, lets_go_slowly),
]
