"""Presses with a known reaction time and a known threshold."""

import numpy as np

from common.tenderness.presses import PressFinder

FINGERS = 2


def press(finder, *, start_s, level_n, threshold_n, reaction_s=0.6, rate_n_s=1.0, x_m=0.0, y_m=0.0, lightly_n=0.0):
    """Press with the first finger, and lightly with the second one 20 mm beside it; lift 0.3 s after a report."""
    begin_s = threshold_n / rate_n_s + reaction_s if threshold_n < level_n else np.inf
    lift_s = min(level_n / rate_n_s + 0.5, begin_s + 0.3)
    reached_n = min(level_n, rate_n_s * lift_s)
    end_s = lift_s + max(0.0, reached_n - threshold_n) / 10.0 + reaction_s
    found = []
    for t_s in np.arange(0.0, lift_s + 3.0, 0.01):
        rising, falling = min(level_n, rate_n_s * t_s), reached_n - 10.0 * (t_s - lift_s)
        force_n = float(max(0.0, rising if t_s < lift_s else falling))
        answer = 4.0 if begin_s <= t_s < end_s else 0.0
        beside_n = min(lightly_n, force_n)
        found.append(finder.step(start_s + float(t_s), [force_n, beside_n], [x_m, x_m + 0.02], [y_m, y_m], answer))
    return [each for each in found if each is not None]


def finder(presses=1000):
    """Return an empty finder."""
    return PressFinder(presses)
