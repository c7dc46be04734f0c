"""Figure of the tactile map: the maps of one sweep, errors of place and value in all sweeps, and found nodules."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from operator_site.console.map.map_layer import CELL_M
from operator_site.console.map.map_tiles import MapPicture
from studies.drawing import WIDEST_IN, Data, figure_file, where
from teletaction.plotting.figure_style import BLACK, BLUE, GREY
from teletaction.report.map_figure import draw_cells, draw_scale

_UNIT = {"temperature": "°C", "roughness": "level of 10", "stiffness": "N/m"}
_GOAL = {"temperature": ("temperature_k", "K"), "stiffness": ("stiffness_share", "%")}


def plot(data: Data, path: Path) -> None:
    """Draw the data of the study, and write the figure as PNG."""
    with figure_file(path, WIDEST_IN, 9.2, dpi=140, layout=None) as figure:
        grid = figure.add_gridspec(
            3, 3, height_ratios=(2.0, 1.0, 0.8), left=0.08, right=0.93, top=0.93, bottom=0.08, wspace=0.62, hspace=0.45
        )
        for column, row in enumerate(where(data["targets"], seed=data["targets"][0]["seed"])):
            _draw_map(figure.add_subplot(grid[0, column]), data, row)
        _draw_places(figure.add_subplot(grid[1, 0]), data)
        for column, quantity in enumerate(("temperature", "stiffness"), 1):
            _draw_values(figure.add_subplot(grid[1, column]), data, quantity)
        _draw_nodules(figure.add_subplot(grid[2, :]), data)


def _draw_map(axes: Axes, data: Data, row: Data) -> None:
    shown, quantity = data["maps"][row["quantity"]], row["quantity"]
    if shown is None:
        return
    value = np.array([[np.nan if v is None else v for v in line] for line in shown["value"]])
    confidence, level = np.array(shown["confidence"], dtype=np.uint8), np.zeros(value.shape, dtype=np.bool_)
    whole = MapPicture(shown["left_m"], shown["near_m"], value, confidence, level)
    draw_cells(axes, quantity, whole, tuple(shown["legend"]))
    known = np.argwhere(~np.isnan(value))
    (low_row, low_column), (high_row, high_column) = known.min(axis=0) - 2, known.max(axis=0) + 3
    axes.set_xlim(*(1e3 * (shown["left_m"] + CELL_M * column) for column in (low_column, high_column)))
    axes.set_ylim(*(1e3 * (shown["near_m"] + CELL_M * row) for row in (low_row, high_row)))
    thing = data["objects"][row["target"]]
    corner = 1e3 * thing["x_m"], 1e3 * thing["y_m"]
    size = 1e3 * thing["length_m"], 1e3 * thing["width_m"]
    axes.add_patch(Rectangle(corner, *size, fill=False, edgecolor=BLACK, linewidth=1.4, linestyle="--"))
    if row["value"] is not None:
        axes.plot(row["x_mm"], row["y_mm"], "+", color=BLACK, markersize=14, markeredgewidth=2)
    axes.set_title(
        f"{row['target'].replace('_', ' ')}: {quantity}, {_UNIT[quantity]}\ndashed: true; cross: found", loc="left"
    )
    draw_scale(axes, quantity, tuple(shown["legend"]))


def _draw_places(axes: Axes, data: Data) -> None:
    names = list(data["objects"])
    for row in data["targets"]:
        if row["place_error_mm"] is not None:
            axes.plot(row["place_error_mm"], names.index(row["target"]), "o", color=BLUE, alpha=0.8)
    axes.axvline(1e3 * data["goals"]["place_m"], color=GREY, linestyle="--")
    axes.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    axes.set(ylim=(len(names) - 0.5, -0.5), xlim=(0.0, None))
    axes.set(xlabel="error of place, mm\n(one dot per session; dashed: goal)")


def _draw_values(axes: Axes, data: Data, quantity: str) -> None:
    goal, unit = _GOAL[quantity]
    rows = [row for row in data["targets"] if row["quantity"] == quantity and row["value"] is not None]
    share = 1.0 if unit == "K" else 100.0 / rows[0]["true_value"] if rows else 1.0
    for number, row in enumerate(rows):
        axes.errorbar(share * row["error"], number, xerr=share * row["sd"], fmt="o", color=BLUE, capsize=3)
    limit = data["goals"][goal] * (1.0 if unit == "K" else 100.0)
    for edge in (-limit, limit):
        axes.axvline(edge, color=GREY, linestyle="--")
    axes.axvline(0.0, color=BLACK, linewidth=0.8)
    axes.set_yticks(range(len(rows)), [f"seed {row['seed']}" for row in rows])
    axes.set(ylim=(len(rows) - 0.5, -0.5), xlabel=f"error of {quantity}, {unit}\n(bars: ± claimed sd; dashed: goal)")


def _draw_nodules(axes: Axes, data: Data) -> None:
    names = list(dict.fromkeys(row["nodule"] for row in sorted(data["nodules"], key=lambda row: -row["true_size_mm"])))
    for row in data["nodules"]:
        if row["place_error_mm"] is not None:
            axes.plot(names.index(row["nodule"]), row["place_error_mm"], "o", color=BLUE, alpha=0.8)
    for at, name in enumerate(names):
        found = [row["probability"] or 0.0 for row in data["nodules"] if row["nodule"] == name]
        axes.text(at, 1.6, f"least probability {min(found):.2f}", ha="center")
    axes.set_xticks(
        range(len(names)),
        [f"{name}\n{next(r['true_size_mm'] for r in data['nodules'] if r['nodule'] == name):.0f} mm" for name in names],
    )
    axes.set(xlim=(-0.5, len(names) - 0.5), ylim=(0.0, 2.0), ylabel="error of place, mm")
    axes.set_title(
        f"nodules in {len({row['seed'] for row in data['nodules']})} sessions "
        f"of {data['palpated_s']:.0f} s, {data['false_outlines']} false outlines",
        loc="left",
    )
