"""A patient with a tender place, whose presses and answers reach a console live or from a recording."""

import math
from collections.abc import Iterator

from common.fingers import FINGER_Y_M
from common.tenderness.patient_row import Patient
from operator_site.console.model import Console
from tests.unit.operator_site.console.fed import INDEX, S, touch

CENTRE_M = (0.025, 0.013)
REACTION_S = 0.6
STEP_S, POLL_S = 0.04, 0.2
"""Interval of the touch packets, and of the console's questions for the answer, s."""
RISE_N_S, FALL_N_S = 1.5, 10.0


def threshold_n(x_m: float, y_m: float) -> float:
    """The patient's threshold at a place."""
    return 6.0 - 4.2 * math.exp(-0.5 * (math.dist((x_m, y_m), CENTRE_M) / 0.01) ** 2)


def samples(x_m: float, y_m: float, level_n: float) -> Iterator[tuple[float, float, float]]:
    """Time from the press's begin, force and answer: the finger rises to a level, holds 0.5 s, and lifts after pain."""
    hurts_n = threshold_n(x_m, y_m)
    begin_s = hurts_n / RISE_N_S + REACTION_S if hurts_n < level_n else math.inf
    lift_s = min(level_n / RISE_N_S + 0.5, begin_s + 0.3)
    reached_n = min(level_n, RISE_N_S * lift_s)
    end_s = lift_s + max(0.0, reached_n - hurts_n) / FALL_N_S + REACTION_S
    for step in range(round((lift_s + 3.0) / STEP_S)):
        t_s = step * STEP_S
        force_n = min(level_n, RISE_N_S * t_s) if t_s < lift_s else reached_n - FALL_N_S * (t_s - lift_s)
        yield t_s, max(0.0, force_n), 6.0 if begin_s <= t_s < end_s else 0.0


def press(console: Console, start_s: float, x_m: float, y_m: float, level_n: float) -> float:
    """Press at a place; return the time of the end."""
    t_s, answered_s, recorded = start_s, -math.inf, None
    for since_s, force_n, answer in samples(x_m, y_m, level_n):
        t_s = start_s + since_s
        if console.live and t_s - answered_s >= POLL_S:
            answered_s = t_s
            console.take_answer(t_s, {"session": 7, "pain": answer, "pain_ns": round(t_s * S), "pain_agreed": True})
        elif not console.live and answer != recorded:
            recorded = answer
            console.take("remote/patient", round(t_s * S), Patient(answer, None).pack())
        values = {"contact": float(force_n > 0.05), "contact_force_n": force_n, "x_m": x_m}
        values["y_m"] = y_m - FINGER_Y_M[INDEX]
        console.take("operator/touch", round(t_s * S), touch(round(t_s / STEP_S), round(t_s * S), **values))
    return t_s + STEP_S


def examine(console: Console, levels_n: tuple[float, ...] = (2.0, 3.5), a_side: int = 5) -> float:
    """Press on a raster, at rising levels; return the time of the end."""
    t_s = 100.0
    for level_n in levels_n:
        for column in range(a_side):
            for row in range(a_side):
                t_s = press(console, t_s, 0.04 * column / (a_side - 1), 0.04 * row / (a_side - 1), level_n)
    return t_s
