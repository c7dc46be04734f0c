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


def falls_late() -> VirtualNode:
    """A force that is commanded to be less is so only after 250 ms."""
    before: list[dict[str, float]] = []

    def hold(values: dict[str, float], _: int) -> dict[str, float]:
        before.append(values)
        old = before[-25:]
        return {
            **values,
            **{finger: max(each[finger] for each in old) for finger in FINGERS if values[finger] > 0.0},
        }

    return changed_states(exoskeleton(), "ExoskeletonState", hold)


def enabled_by_any_frame() -> VirtualNode:
    end = exoskeleton()

    def say(values: dict[str, float], _: int) -> dict[str, float]:
        return {**values, "enabled": float(end.node.alive("FingerForces", end.now()))}

    return changed_states(end, "ExoskeletonState", say)


WRONG_EXOSKELETONS: WrongNodes = [
    ("E1", EXO, crossed_fingers),
    ("E2", EXO, enabled_or_not),
    ("E3", EXO, lets_go_slowly),
    ("E4", EXO, falls_late),
    ("E5", EXO, enabled_by_any_frame),
]
