"""Measures the cost of an update in units of one numpy product of two 100 x 100 matrices, timed alternately."""

from collections.abc import Callable, Sequence
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from remote_site.thermal.exponential_response import ExponentialResponse
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.shared_object import SharedObject
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge
from studies.thermal_identification.exponential import LaggedResponse, Response
from studies.thermal_identification.reference import Reference
from studies.thermal_identification.situations import Hand

BASELINE = "one product of two 100 x 100 matrices (numpy, float64, one thread)"
EARLY_S = 0.2
"""Time after contact that separates early from late costs, s; every hypothesis is still followed before it."""
_SIZE = 100
Update = Callable[[int], object]


def cost(updates: Sequence[Callable[[], Update]], readings: int) -> tuple[dict[str, float], dict[str, float]]:
    """Time updates in alternation with the baseline; return early, late and overall costs, in baselines and in us.

    Each of `updates` returns an update for reading k of a touch, 1 <= k <= `readings`.
    """
    left, right = np.random.default_rng(0).standard_normal((2, _SIZE, _SIZE))
    unit_s = list[float]()
    took_s = np.empty((len(updates), readings))
    for row, make in zip(took_s, updates, strict=True):
        update = make()
        for k in range(1, readings + 1):
            begin_s = perf_counter()
            np.matmul(left, right)
            unit_s.append(perf_counter() - begin_s)
            begin_s = perf_counter()
            update(k)
            row[k - 1] = perf_counter() - begin_s
    # the median over touches removes the time slices of other programs
    middle_s, early = np.median(took_s, axis=0), round(EARLY_S * 100)
    parts_s = {
        "early": float(middle_s[:early].mean()),
        "late": float(middle_s[early:].mean()),
        "all": float(middle_s.mean()),
    }
    unit = float(np.median(unit_s))
    return {k: round(v / unit, 3) for k, v in parts_s.items()}, {k: round(v * 1e6, 2) for k, v in parts_s.items()}


def exponential_update(response: Callable[[float], Response], hand: Hand) -> Update:
    """Return an update that adds one reading to a fit and solves it."""
    touch, readings = hand.fingers[0], list(hand.fingers[0].readings())
    running = response(touch.start_c)

    def update(k: int) -> None:
        running.add(readings[k][0], readings[k][1])
        running.fit()

    return update


def finger_update(knowledge: ThermalKnowledge, hand: Hand, fingers: int) -> Update:
    """Return an update that takes one reading of each finger as a session does, with a joint answer of several."""
    identifications = [ThermalIdentification(knowledge) for _ in range(fingers)]
    readings = [list(finger.readings()) for finger in hand.fingers[:fingers]]
    for identification, finger in zip(identifications, hand.fingers, strict=False):
        identification.start(0.0, finger.start_c, finger.slope_k_s, finger.ambient_c)
    shared, numbered = SharedObject(knowledge), dict(enumerate(identifications))

    def update(k: int) -> None:
        for identification, each in zip(identifications, readings, strict=True):
            identification.step(*each[k])
        if fingers > 1:
            shared.step(numbered)

    return update


def costs(
    knowledge: ThermalKnowledge,
    hands: Sequence[Hand],
    fingers: Sequence[int],
    reference: Reference,
    row: Any,
    readings: int,
) -> list[dict[str, Any]]:
    """Return a row for each method: cost per finger and update, over the first `readings` after contact.

    The reference classifies the same `row` in each update.
    """
    ways: list[tuple[str, int, list[Callable[[], Update]]]] = [
        ("paper", 1, [partial(exponential_update, ExponentialResponse, hand) for hand in hands]),
        ("good exponential", 1, [partial(exponential_update, LaggedResponse, hand) for hand in hands]),
        ("reference", 1, [lambda: lambda _: reference.judge(row)] * len(hands)),
    ]
    ways += [
        (
            f"{count} finger" + ("s" if count > 1 else ""),
            count,
            [partial(finger_update, knowledge, hand, count) for hand in hands],
        )
        for count in fingers
    ]
    return [_row(method, count, cost(updates, readings)) for method, count, updates in ways]


def cost_by_materials(
    table: MaterialTable, hands: Sequence[Hand], counts: Sequence[int], readings: int
) -> list[dict[str, Any]]:
    """Return a row for each number of the table's first materials: cost of one finger, and number of hypotheses."""
    rows = []
    for count in counts:
        knowledge = ThermalKnowledge.of(table.model_copy(update={"materials": table.materials[:count]}))
        updates = [partial(finger_update, knowledge, hand, 1) for hand in hands]
        found = _row("1 finger", 1, cost(updates, readings))
        rows.append({"materials": count, "guesses": len(knowledge.guesses.substance), **found})
    return rows


def _row(method: str, fingers: int, found: tuple[dict[str, float], dict[str, float]]) -> dict[str, Any]:
    ratio, took_us = found
    return {
        "method": method,
        "fingers": fingers,
        **{f"ratio_{part}": round(value / fingers, 3) for part, value in ratio.items()},
        **{f"us_{part}": round(value / fingers, 2) for part, value in took_us.items()},
    }
