"""Figure of simulated nodules: AUC in each cell, missed nodules, calibration, and presses one after another."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from sim_sensors.tissue.contrast import Sphere
from sim_sensors.tissue.ground import Ground, force_at
from studies.drawing import WIDEST_IN, Data, Rows, curve, figure_file, where
from studies.nodules.ranges import DEPTH_EDGES_MM, RANGES, RATIO_EDGES, SIZE_EDGES_MM
from studies.nodules.sequential import INNER, NEXT, RANDOM, RASTER
from teletaction.plotting.figure_style import BLACK, BLUE, GREY

CHANCE_AUC = 0.6
"""AUC below which a cell counts as impossible."""
GOAL_AUC = 0.02
"""Difference between the AUC of the detector and of the reference that counts as equal."""
GOAL_SAVED = 0.3
"""Share of presses that the chosen places should save at the AUC of a raster."""
EFFECTS = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Contours of the growth of force over a nodule's middle."""
PRESSED_MM = 3.0
"""Depth of the press of these contours, mm."""
_GROUND = Ground(young_kpa=10.0, exponent=1.5, layer_mm=60.0, probe_mm=6.0)
_RATIO_OF_CONTOURS = (2.0, 5.0, 12.6)
"""Stiffness ratios of the contours: the middle of each class."""
_POINTS = 24
_WAYS: dict[str, dict[str, Any]] = {
    RASTER: {"color": BLACK, "linestyle": "-"},
    INNER: {"color": BLACK, "linestyle": "--"},
    RANDOM: {"color": GREY, "linestyle": ":"},
    NEXT: {"color": BLUE, "linestyle": "-"},
}


def plot(data: Data, path: Path) -> None:
    """Draw the data of the study, and write the figure as PNG."""
    with figure_file(path, WIDEST_IN, 19.0, dpi=130) as figure:
        reference, detector, effects, whole, sequences = figure.subplots(5, 3)
        for column, size in enumerate(pairwise(SIZE_EDGES_MM)):
            draw_cells(reference[column], data["cells"], size, "reference")
            draw_cells(detector[column], data["detector_cells"], size, "detector")
        for axes, limits, ratio in zip(effects, pairwise(RATIO_EDGES), _RATIO_OF_CONTOURS, strict=True):
            draw_effect(axes, data, limits, ratio)
        for axes, draw in zip(whole, (draw_reliability, draw_sizes, draw_differences), strict=True):
            draw(axes, data)
        draw_sequences(sequences, data)
        figure.legend(*effects[0].get_legend_handles_labels(), loc="outside lower left", ncols=2)


def draw_cells(axes: Axes, cells: Rows, size: tuple[float, float], who: str) -> None:
    """Draw AUC over depth and ratio for one class of size; a hatched cell is impossible."""
    rows = where(cells, size_mm_from=size[0])
    axes.set_title(f"AUC of the {who}, {size[0]:g} to {size[1]:g} mm", loc="left")
    for column, ratio in enumerate(RATIO_EDGES[:-1]):
        for line, depth in enumerate(DEPTH_EDGES_MM[:-1]):
            (row,) = where(rows, ratio_from=ratio, depth_mm_from=depth)
            auc = row["auc"]
            shade = 1.0 if auc is None else 1.0 - 0.8 * max(0.0, 2.0 * auc - 1.0)
            hatch = "//" if auc is not None and auc < CHANCE_AUC else None
            axes.fill_between(
                [column, column + 1], line, line + 1, facecolor=(shade, shade, 1.0), edgecolor=GREY, hatch=hatch
            )
            error = "" if row["auc_se"] is None else f" ± {row['auc_se']:.2f}"
            text = "no nodule" if auc is None else f"{auc:.2f}{error}\n{row['nodules']} nodules"
            axes.text(column + 0.5, line + 0.5, text, ha="center", va="center", fontsize=8)
    axes.set_xticks(range(len(RATIO_EDGES)), [f"{edge:g}" for edge in RATIO_EDGES])
    axes.set_yticks(range(len(DEPTH_EDGES_MM)), [f"{edge:g}" for edge in DEPTH_EDGES_MM])
    axes.invert_yaxis()
    axes.set_xlabel("stiffness ratio")
    axes.set_ylabel("depth of the top (mm)")


def draw_effect(axes: Axes, data: Data, limits: tuple[float, float], ratio: float) -> None:
    """Draw the nodules that the detector finds and misses, over size and depth, and contours of their added force."""
    sizes = np.geomspace(*RANGES.size_mm, _POINTS)
    depths = np.geomspace(*RANGES.depth_mm, _POINTS)
    _, plain = force_at(_GROUND, [], np.zeros(1), np.zeros(1), PRESSED_MM)
    effect = [[_force(size, depth, ratio) / plain[0, -1] - 1.0 for size in sizes] for depth in depths]
    lines = axes.contour(sizes, depths, effect, levels=EFFECTS, colors=GREY, linewidths=0.9)
    axes.clabel(lines, fmt=lambda value: f"+{100.0 * value:.0f} %", fontsize=7)
    rows = [row for row in data["detector_nodules"] if limits[0] <= row["ratio"] < limits[1]]
    for found, colour, marker in ((True, BLUE, "o"), (False, BLACK, "x")):
        mine = [row for row in rows if (row["score"] >= 0.5) == found]
        label = "probability of 0.5 or more" if found else "less"
        curve(axes, mine, "size_mm", "depth_mm", marker=marker, linestyle="", color=colour, markersize=4, label=label)
    axes.set(xscale="log", yscale="log", xlabel="diameter (mm)", ylabel="depth of the top (mm)")
    axes.set_xticks(SIZE_EDGES_MM, [f"{edge:g}" for edge in SIZE_EDGES_MM])
    axes.set_yticks(DEPTH_EDGES_MM, [f"{edge:g}" for edge in DEPTH_EDGES_MM])
    axes.minorticks_off()
    axes.invert_yaxis()
    axes.set_title(f"ratio {limits[0]:g} to {limits[1]:g};\ncontours: added force, {ratio:g}", loc="left", fontsize=9)


def draw_reliability(axes: Axes, data: Data) -> None:
    """Draw the share of places above a nodule over the stated probability."""
    axes.plot([0.0, 1.0], [0.0, 1.0], color=GREY, linewidth=0.8)
    for name, colour, label in (("reliability", GREY, "reference"), ("detector_reliability", BLUE, "detector")):
        rows = [row for row in data[name] if row["places"]]
        curve(axes, rows, "stated", "true", marker="o", color=colour, label=label)
    axes.set_xlabel("stated probability of a place")
    axes.set_ylabel("share of these places above a nodule")
    axes.set_title("Calibration, all phantoms", loc="left")
    axes.legend(loc="upper left", fontsize=7)


def draw_sizes(axes: Axes, data: Data) -> None:
    """Draw the found diameters over the true ones, of nodules that the detector finds with a probability of 0.5."""
    found = [row for row in data["detector_nodules"] if row["probability"] is not None]
    rows = [row for row in found if row["probability"] >= 0.5]
    axes.plot(RANGES.size_mm, RANGES.size_mm, color=GREY, linewidth=0.8)
    curve(axes, rows, "size_mm", "found_size_mm", marker="o", linestyle="", color=BLUE, markersize=4)
    axes.set_xlabel("diameter (mm)")
    axes.set_ylabel("diameter found by the detector (mm)")
    axes.set_title("Size of found nodules", loc="left")


def draw_differences(axes: Axes, data: Data) -> None:
    """Draw the AUC of the detector over that of the reference, a point for each cell, and the goal.

    Bars are standard errors of the difference.
    """
    pairs = [
        (known["auc"], found["auc"], apart["difference_se"] or 0.0)
        for known, found, apart in zip(data["cells"], data["detector_cells"], data["differences"][:-1], strict=True)
        if found["auc"] is not None
    ]
    ends = np.array([0.4, 1.0])
    axes.fill_between(ends, ends - GOAL_AUC, ends + GOAL_AUC, color=GREY, alpha=0.3, linewidth=0.0)
    reference, detector, deviation = zip(*pairs, strict=True)
    axes.errorbar(reference, detector, deviation, fmt="o", color=BLUE, markersize=4, linewidth=0.6)
    axes.set_xlabel("AUC of the reference")
    axes.set_ylabel("AUC of the detector")
    axes.set_title(f"Each cell; grey: within {GOAL_AUC:g}", loc="left")


def draw_sequences(row: Sequence[Axes], data: Data) -> None:
    """Draw AUC and place over the number of presses for each way, and the presses that each way saves."""
    auc, place, share = row
    for way, style in _WAYS.items():
        rows = where(data["sequences"], way=way)
        curve(auc, rows, "presses", "auc", **style, label=way)
        curve(place, rows, "presses", "within_3_mm", (1.0, 100.0), **style, label=way)
    auc.set(xlabel="presses", ylabel="AUC over all nodules")
    auc.set_title("Presses one after another", loc="left")
    auc.legend(loc="lower right", fontsize=7)
    place.set(xlabel="presses", ylabel="nodules placed within 3 mm (%)")
    place.set_title("Place", loc="left")
    for number, one in enumerate(data["saved"]):
        ends = [100.0 * one["saved_from"], 100.0 * one["saved_to"]]
        share.plot(ends, [number, number], color=_WAYS[one["way"]]["color"], linewidth=1.5)
        share.plot(100.0 * one["saved"], number, "o", color=_WAYS[one["way"]]["color"], markersize=4)
    share.set_yticks(
        range(len(data["saved"])), [f"{one['way']}, {one['raster_presses']}" for one in data["saved"]], fontsize=7
    )
    share.axvline(100.0 * GOAL_SAVED, color=GREY, linewidth=0.8)
    share.set_xlabel("presses saved (%), 90 % interval; line: goal")
    share.set_title("At the AUC of a raster of 30 or 60", loc="left")


def _force(size_mm: float, depth_mm: float, ratio: float) -> float:
    sphere = Sphere(0.0, 0.0, float(size_mm), float(depth_mm), ratio)
    return float(force_at(_GROUND, [sphere], np.zeros(1), np.zeros(1), PRESSED_MM)[1][0, -1])
