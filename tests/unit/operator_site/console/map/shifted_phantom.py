"""A phantom that moves under random touches; run as a module, it prints when the movement is noticed, as a table."""

import math
from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from common.fingers import FINGER_Y_M
from operator_site.console.map.patient_shift import Contact, Movement, PatientShift
from tests.unit.operator_site.console.fed import INDEX, S, touch

RADIUS_M = 0.060
"""Radius of the curved phantom, m."""
SIDE_M = 0.040
"""Side of the touched square, m."""
HEIGHT_SD_M = 0.00015
"""Standard deviation of a measured height, m."""
BREATHS_HZ = 14.0 / 60.0
BEFORE, AFTER = 60, 30
"""Number of contacts before the movement, and after it."""
SHIFTS_M = [*product(("normal",), (0.002, 0.005, 0.010)), *product(("sideways",), (0.002, 0.005, 0.010))]


class Noticed(NamedTuple):
    """The movement that was noticed, and the number of contacts since it happened, 0 or less for a false alarm."""

    movement: Movement
    after: int


def height_m(x_m: float, y_m: float, *, curved: bool) -> float:
    return -(x_m**2 + y_m**2) / (2.0 * RADIUS_M) if curved else 0.0


def contacts(
    seed: int, way: str, by_m: float, *, curved: bool, breath_m: float, before: int = BEFORE, after: int = AFTER
) -> Iterator[Contact]:
    """Contacts at random places and times, the first ones before the movement."""
    rng = np.random.default_rng(seed)
    t_s, phase = 0.0, rng.uniform(0.0, 2.0 * math.pi)
    for number in range(before + after):
        x_m, y_m = rng.uniform(-0.5 * SIDE_M, 0.5 * SIDE_M, 2).tolist()
        t_s += rng.uniform(1.5, 3.5)
        moved_m = by_m if number >= before else 0.0
        ground_m = height_m(x_m - (moved_m if way == "sideways" else 0.0), y_m, curved=curved)
        breath = breath_m * math.sin(2.0 * math.pi * BREATHS_HZ * t_s + phase)
        lifted_m = moved_m if way == "normal" else 0.0
        yield Contact(t_s, x_m, y_m, ground_m + lifted_m + breath + HEIGHT_SD_M * rng.standard_normal())


def noticed(seed: int, way: str, by_m: float, *, curved: bool, breath_m: float, before: int = BEFORE) -> Noticed | None:
    """Touch a phantom until a movement is noticed; None without one."""
    watch = PatientShift()
    made = contacts(seed, way, by_m, curved=curved, breath_m=breath_m, before=before)
    for number, contact in enumerate(made, 1):
        if (movement := watch.take(contact)) is not None:
            return Noticed(movement, number - before)
    return None


def packets(seed: int, by_m: float) -> Iterator[tuple[int, bytes]]:
    """Time, ns, and touch packets of the index finger on a flat phantom that moves along its normal."""
    sequence = 0
    for contact in contacts(seed, "normal", by_m, curved=False, breath_m=0.0):
        for step in range(4):
            sequence += 1
            at_ns = round((100.0 + contact.t_s + 0.2 * step) * S)
            place = {"x_m": contact.x_m, "y_m": contact.y_m - FINGER_Y_M[INDEX], "surface_z_m": contact.z_m}
            yield at_ns, touch(sequence, at_ns, contact=float(step < 3), **place)


def table(seeds: int = 60) -> str:
    """For each phantom and movement: how often it was noticed, and after how many contacts."""
    lines = [
        "| phantom | breathing, mm | movement | noticed | contacts: median, most | false alarms before |",
        "|---|---|---|---|---|---|",
    ]
    for curved, breath_m, (way, by_m) in product((False, True), (0.0, 0.001, 0.0015), SHIFTS_M):
        found = [noticed(seed, way, by_m, curved=curved, breath_m=breath_m) for seed in range(seeds)]
        after = sorted(each.after for each in found if each is not None and each.after > 0)
        early = sum(each is not None and each.after <= 0 for each in found)
        shown = f"{after[len(after) // 2]}, {after[-1]}" if after else "–"
        phantom = f"curved, {1e3 * RADIUS_M:.0f} mm" if curved else "flat"
        movement = f"{1e3 * breath_m:g} | {1e3 * by_m:g} mm {way}"
        lines.append(f"| {phantom} | {movement} | {len(after)} of {seeds} | {shown} | {early} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
