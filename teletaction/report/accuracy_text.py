"""Describes as text how far a calibrated thermal table can be trusted: its discrepancy, and the accuracy to expect."""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from remote_site.thermal.calibration.expected_accuracy import FOLDS, Judged, judge_in_folds
from remote_site.thermal.calibration.temperature_calibration import TemperatureFit
from remote_site.thermal.calibration.thermal_calibration import ThermalFit
from remote_site.thermal.discrepancy import Discrepancy
from remote_site.thermal.material_table import MaterialTable

PROBABILITIES = (0.0, 0.5, 0.8, 0.95, 0.99, 1.0)
"""Limits of the classes of stated probability in the reliability table."""
WITHIN_SD = 1.96
"""Standard deviations of the stated 95 % interval."""
NOT_KNOWN = "-"
_COLUMNS = ("right %", "median error K", "stated +- K", "inside 95 % (%)")


def temperature_text(fit: TemperatureFit) -> str:
    """Return the errors that a temperature calibration learned, the accuracy to expect, and warnings."""
    head = f"sensor {fit.table.sensor_serial}, {fit.table.made_on or 'no date'}: temperatures"
    return "\n".join([head, "", *accuracy_lines(fit), *(f"warning: {warning}" for warning in fit.warnings)])


def accuracy_lines(fit: ThermalFit | TemperatureFit) -> list[str]:
    """Return the size of the discrepancy, the accuracy to expect, and the reliability of stated probabilities."""
    discrepancy = fit.table.discrepancy
    if discrepancy is None:
        return []
    judged = judge_in_folds(fit.before, fit.seen)
    names = fit.table.names()
    lines = _discrepancy_lines(fit.table, discrepancy)
    if not judged:
        return lines
    times_s = sorted({one.t_s for one in judged})
    at = " / ".join(f"{t_s:g}" for t_s in times_s)
    lines += [
        "",
        f"expected {at} s after contact (discrepancy learned from {FOLDS - 1} of {FOLDS} parts of the touches)",
    ]
    one, two = ([each for each in judged if each.fingers == fingers] for fingers in (1, 2))
    lines += _table("one finger", names, times_s, one)
    if two:
        lines += _table("two fingers", names, times_s, two)
        lines.append(
            "Two fingers are two touches moved to one object temperature: errors that they share are left out."
        )
    if isinstance(fit, ThermalFit):
        lines.append("The populations were fitted to these same touches, so that new touches can be slightly worse.")
    return [*lines, "", *_reliability_lines(one)]


def _discrepancy_lines(table: MaterialTable, discrepancy: Discrepancy) -> list[str]:
    """Describe what the model leaves out, at the first, middle and last time of the discrepancy."""
    shown = sorted({k for t_s in (0.5, 1.0, 3.0, 6.0) if (k := _nearest(discrepancy.times_s, t_s)) is not None})
    at = " / ".join(f"{discrepancy.times_s[k]:g}" for k in shown)
    lines = [
        f"left out by the model {at} s after contact, at the plate's temperature in calibration",
        f"{'material':<16}{'objects K':>14}{'error K (subtracted)':>30}{'rest +- K':>30}",
    ]
    unknown = []
    for number, entry in enumerate(table.materials):
        plate_k = discrepancy.plate_k[number]
        error_k = [
            discrepancy.by_plate[k][number] * plate_k + discrepancy.by_object[k][number] * entry.offset_k for k in shown
        ]
        rest_k = [discrepancy.spread[k][number] * abs(plate_k - entry.offset_k) for k in shown]
        known = discrepancy.known_objects[number]
        if not known:
            unknown.append(entry.name)
        error = " ".join(f"{value:+6.2f}" for value in error_k) if known else "not known"
        objects = (
            f"{discrepancy.coldest_k[number]:+.1f}..{discrepancy.warmest_k[number]:+.1f}" if known else "not known"
        )
        rest = " ".join(f"{value:6.2f}" for value in rest_k)
        lines.append(f"{entry.name:<16}{objects:>14}{error:>30}{rest:>30}")
    stated = " / ".join(f"{discrepancy.stated_sd[k]:.2f}" for k in shown)
    power = " / ".join(f"{discrepancy.sharpness[k]:.2f}" for k in shown)
    lines.append(f"stated +- times {stated}, likelihood of materials to the power of {power}")
    lines.append("objects K: their temperatures above ambient; the +- of colder and warmer ones is wider")
    if unknown:
        lines.append(
            f"no known object temperature: {', '.join(unknown)}. Their error cannot be learned and their +- stays wide;"
        )
        lines.append("`teletaction calibrate temperature` learns it from references of known temperature.")
    return lines


def _nearest(times_s: Sequence[float], t_s: float) -> int | None:
    """Return the index of a time, or of the last one before it; None if all are later."""
    return next((k for k in reversed(range(len(times_s))) if times_s[k] <= t_s + 1e-9), None)


def _table(title: str, names: Sequence[str], times_s: Sequence[float], judged: Sequence[Judged]) -> list[str]:
    """Return a line for each material, with a value for each time in each column."""
    width = max(6 * len(times_s), *(len(column) + 2 for column in _COLUMNS))
    lines = [f"{title:<16}" + "".join(f"{column:>{width}}" for column in _COLUMNS)]
    for number, name in enumerate(names):
        mine = [one for one in judged if one.material == number]
        if not mine:
            continue
        each = [[one for one in mine if one.t_s == t_s] for t_s in times_s]
        cells = (_right, _error, _stated, _within)
        columns = ("".join(f"{_shown(cell, there):>6}" for there in each) for cell in cells)
        lines.append(f"{name:<16}" + "".join(f"{text:>{width}}" for text in columns))
    return lines


def _shown(cell: Callable[[Sequence[Judged]], str], judged: Sequence[Judged]) -> str:
    return cell(judged) if judged else NOT_KNOWN


def _right(judged: Sequence[Judged]) -> str:
    return f"{100.0 * np.mean([one.right for one in judged]):.0f}"


def _error(judged: Sequence[Judged]) -> str:
    errors_k = [abs(one.error_k) for one in judged if one.error_k is not None]
    return f"{np.median(errors_k):.2f}" if errors_k else NOT_KNOWN


def _stated(judged: Sequence[Judged]) -> str:
    return f"{np.median([one.sd_k for one in judged]):.2f}"


def _within(judged: Sequence[Judged]) -> str:
    inside = [abs(one.error_k) <= WITHIN_SD * one.sd_k for one in judged if one.error_k is not None]
    return f"{100.0 * np.mean(inside):.0f}" if inside else NOT_KNOWN


def _reliability_lines(judged: Sequence[Judged]) -> list[str]:
    """Compare stated probabilities of the likeliest material with the share of right ones."""
    lines = [
        "reliability, one finger, all these times",
        f"{'stated %':<16}{'answers':>10}{'mean stated %':>16}{'right %':>10}",
    ]
    for low, high in pairwise(PROBABILITIES):
        mine = [one for one in judged if low < one.probability <= high]
        if mine:
            stated, right = np.mean([one.probability for one in mine]), np.mean([one.right for one in mine])
            span = f"{100 * low:.0f}..{100 * high:.0f}"
            lines.append(f"{span:<16}{len(mine):>10}{100 * stated:>16.1f}{100 * right:>10.1f}")
    return lines
