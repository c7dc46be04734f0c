"""Draws the tactile map: cells on a hatched ground, a scale with confidence, findings as numbers.

For greyscale prints, signs mark temperatures above and below the middle of the scale, and letters mark materials.
"""

from collections.abc import Iterable, Mapping, Sequence
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon, Rectangle
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from operator_site.console.map import colours
from operator_site.console.map.map_layer import CELL_M
from operator_site.console.map.map_tiles import MapPicture, picture
from operator_site.console.map.roughness_shown import LEVEL_0_V, LEVEL_10_V, roughness_shown
from operator_site.console.map.tactile_map import LOGARITHMIC, QUANTITIES, STALE_M, TactileMap
from operator_site.console.texts import named, percent

Floats = NDArray[np.float64]
UNITS = {"temperature": "°C", "roughness": "of 10", "stiffness": "N/m"}
GROUND = "#" + colours.BACKGROUND
"""Colour of the area that was not felt."""
_SIGN_EVERY = 3
"""Distance between two signs, cells."""
_SIGN_K = 1.0
"""Smallest difference from the middle of the scale that gets a sign, K."""
_STEEP_HATCH = "xxxx"
_MARGIN_M = 4e-3
"""Margin around the felt area, m."""
_LEFT_IN, _RIGHT_IN, _BELOW_IN, _ABOVE_IN = 0.62, 1.15, 0.5, 0.28
"""Room around a map for its labels and its scale, inches."""
_TICK_IN = 0.15
"""Least distance of two ticks on a scale, inches."""
_LOWEST_IN = 0.9
"""Least height of a map, so that its scale can be read, inches."""
HALO = withStroke(linewidth=2.6, foreground="#FFFFFF")
"""White around outlines and their labels, so that they stand out on every colour."""
_EDGE = withStroke(linewidth=1.2, foreground="#000000")
"""Black around white signs and letters, so that they stand out on every colour."""
_KEY_LETTERS = 14
"""Longest line of a material's name, so that it fits beside the map, characters."""


def _rgb(colour: str) -> list[float]:
    return [part / 255.0 for part in bytes.fromhex(colour)]


_TABLES = {
    (quantity, confidence): np.array([_rgb(colours.shown(colour, confidence)) for colour in table])
    for quantity, table in colours.TABLES.items()
    for confidence in range(4)
}
_MATERIALS = [
    np.array([_rgb(colours.shown(colour, confidence)) for colour in [*colours.MATERIALS, colours.OTHER_MATERIAL]])
    for confidence in range(4)
]


def cell_colours(quantity: str, shown: MapPicture, legend: tuple[float, float]) -> Floats:
    """Return red, green, blue and opacity of each cell, 0..1, (rows, columns, 4); opacity 0 where nothing was felt."""
    colour = np.zeros((*shown.value.shape, 4))
    known = ~np.isnan(shown.value)
    colour[known, 3] = 1.0
    for step in range(4):
        mine = known & (shown.confidence == step)
        if quantity == "material":
            place = np.minimum(shown.value[mine], len(colours.MATERIALS)).astype(int)
            colour[mine, :3] = _MATERIALS[step][place]
        else:
            share = on_scale(quantity, shown.value[mine], legend)
            colour[mine, :3] = _TABLES[quantity, step][np.round(255 * share).astype(int)]
    return colour


def on_scale(quantity: str, value: Floats, legend: tuple[float, float]) -> Floats:
    """Map values to positions on a scale, 0..1; values beyond its ends are clipped."""
    low, high = legend
    if quantity in LOGARITHMIC:
        value, low, high = np.log(value), float(np.log(low)), float(np.log(high))
    share: Floats = np.clip((value - low) / (high - low), 0.0, 1.0)
    return share


def draw_cells(axes: Axes, quantity: str, shown: MapPicture, legend: tuple[float, float]) -> None:
    """Draw the cells in mm. Steep ground is hatched; low confidence is stippled; no confidence is a dot alone."""
    rows, columns = shown.value.shape
    left, near, cell = 1e3 * shown.left_m, 1e3 * shown.near_m, 1e3 * CELL_M
    extent = (left, left + cell * columns, near, near + cell * rows)
    axes.set_facecolor(GROUND)
    axes.patch.set(hatch="////", edgecolor="#99A0A8", linewidth=0.0)
    axes.imshow(cell_colours(quantity, shown, legend), origin="lower", extent=extent, interpolation="nearest")
    for step, size in ((0, 1.6), (1, 0.8)):
        vague = np.argwhere(~np.isnan(shown.value) & (shown.confidence == step))
        vague = vague[(vague.sum(axis=1) % 2 == 0) & (vague[:, 0] % 2 == 0)]
        axes.plot(
            left + cell * (vague[:, 1] + 0.5), near + cell * (vague[:, 0] + 0.5), ".", color="#000000", markersize=size
        )
    if shown.steep.any():
        x, y = left + cell * (np.arange(columns) + 0.5), near + cell * (np.arange(rows) + 0.5)
        axes.contourf(x, y, shown.steep, levels=[0.5, 1.5], colors="none", hatches=[_STEEP_HATCH])
    if quantity == "temperature":
        _draw_signs(axes, shown, sum(legend) / 2.0)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel("x, mm")
    axes.set_ylabel("y, mm")


def _draw_signs(axes: Axes, shown: MapPicture, middle_c: float) -> None:
    """Draw plus and minus signs where the map is clearly warmer or colder than the middle of the scale."""
    part = slice(_SIGN_EVERY // 2, None, _SIGN_EVERY)
    value, sure = shown.value[part, part], shown.confidence[part, part] > 0
    for sign, marker in ((1.0, "+"), (-1.0, "_")):
        rows, columns = np.nonzero(sure & (sign * (np.nan_to_num(value, nan=middle_c) - middle_c) >= _SIGN_K))
        x = 1e3 * (shown.left_m + CELL_M * (_SIGN_EVERY * columns + _SIGN_EVERY // 2 + 0.5))
        y = 1e3 * (shown.near_m + CELL_M * (_SIGN_EVERY * rows + _SIGN_EVERY // 2 + 0.5))
        axes.plot(x, y, marker, color="#FFFFFF", markersize=3.5, markeredgewidth=0.8, path_effects=[_EDGE])


def draw_scale(axes: Axes, quantity: str, legend: tuple[float, float]) -> None:
    """Draw a scale beside the cells: values rise upwards; each column is a confidence."""
    scale = axes.inset_axes((1.03, 0.0, 0.085, 1.0))
    upwards = np.round(255 * np.linspace(0.0, 1.0, 256)).astype(int)
    strip = np.stack([_TABLES[quantity, step][upwards] for step in (1, 2, 3)], axis=1)
    scale.imshow(strip, origin="lower", aspect="auto", extent=(0.5, 3.5, 0.0, 1.0))
    ticks = scale_ticks(quantity, legend)
    room = max(2, int(axes.bbox.height / axes.figure.dpi / _TICK_IN))
    ticks = ticks[:: -(-len(ticks) // room) or 1]
    scale.set_yticks(on_scale(quantity, np.array(ticks), legend).tolist(), _labels(quantity, ticks))
    scale.yaxis.tick_right()
    scale.set_xticks([0.7, 3.3], ["vague", "sure"], fontsize=6.5, rotation=90)
    scale.tick_params(length=2)
    scale.grid(visible=False)
    scale.set_title(UNITS[quantity], fontsize=8.5)


def _labels(quantity: str, ticks: Sequence[float]) -> list[str]:
    if quantity == "roughness":
        return [f"{roughness_shown(tick, tick, None).value:.0f}" for tick in ticks]
    return [f"{tick:g}" for tick in ticks]


def scale_ticks(quantity: str, legend: tuple[float, float]) -> list[float]:
    """Return round numbers for the ticks of a scale; of roughness, the values of even levels, V."""
    low, high = legend
    if quantity == "roughness":
        return [LEVEL_0_V * (LEVEL_10_V / LEVEL_0_V) ** (level / 10.0) for level in range(0, 11, 2)]
    if quantity not in LOGARITHMIC:
        return [float(tick) for tick in np.arange(np.ceil(low), np.floor(high) + 0.5)]
    steps = [digit * 10.0**power for power in range(-6, 7) for digit in (1, 2, 5)]
    return [step for step in steps if low * 0.999 <= step <= high * 1.001]


def draw_stale(axes: Axes, tactile_map: TactileMap) -> None:
    """Stripe the squares that were felt before the patient has moved, and not since."""
    for x_m, y_m in tactile_map.stale():
        place, side = (1e3 * x_m, 1e3 * y_m), 1e3 * STALE_M
        axes.add_patch(
            Rectangle(place, side, side, facecolor="none", edgecolor="#000000", hatch="\\\\\\", linewidth=0.0)
        )


def draw_findings(axes: Axes, findings: Iterable[Mapping[str, Any]]) -> None:
    """Draw each finding's number beside its place."""
    for finding in findings:
        if finding.get("x_m") is None or finding.get("y_m") is None:
            continue
        place = 1e3 * float(finding["x_m"]), 1e3 * float(finding["y_m"])
        axes.plot(*place, "o", markersize=6, markerfacecolor="none", markeredgecolor="#000000", markeredgewidth=1.4)
        axes.annotate(
            str(int(finding["id"])),
            place,
            xytext=(9, 9),
            textcoords="offset points",
            fontsize=9.5,
            fontweight="bold",
            ha="center",
            va="center",
            bbox={"boxstyle": "round,pad=0.22", "facecolor": "white", "edgecolor": "black", "linewidth": 1.0},
            arrowprops={"arrowstyle": "-", "linewidth": 1.0},
        )


def draw_lumps(axes: Axes, lumps: Iterable[Mapping[str, Any]]) -> None:
    """Draw the dashed outline of each lump with its probability, %, beside it."""
    for lump in lumps:
        outline = Polygon(lump["outline_mm"], facecolor="none", edgecolor="#000000", linestyle="--", linewidth=1.2)
        axes.add_patch(outline).set_path_effects([HALO])
        lowest_mm = min(y for _, y in lump["outline_mm"]) - 0.8
        how: dict[str, Any] = {"fontsize": 7.5, "ha": "center", "va": "top", "path_effects": [HALO], "clip_on": True}
        axes.text(lump["x_mm"], lowest_mm, f"lump {percent(lump['probability'])}", **how)


def map_figure(
    tactile_map: TactileMap,
    quantity: str,
    findings: Iterable[Mapping[str, Any]],
    width_in: float = 4.6,
    highest_in: float = 3.9,
    lumps: Iterable[Mapping[str, Any]] = (),
) -> Figure | None:
    """Draw the whole map of a quantity with findings and outlines of lumps; return None if it was never felt.

    The figure is `width_in` wide and as high as the map needs, at most `highest_in` (inches).
    """
    shown = picture(tactile_map, quantity)
    if shown is None:
        return None
    bounds = _bounds(tactile_map)
    (left, right), (low, high) = bounds["xlim"], bounds["ylim"]
    map_in = (width_in - _LEFT_IN - _RIGHT_IN) * (high - low) / (right - left)
    figure, axes = _one_map((width_in, min(highest_in, _BELOW_IN + _ABOVE_IN + max(_LOWEST_IN, map_in))))
    draw_map(axes, tactile_map, quantity, shown)
    draw_stale(axes, tactile_map)
    axes.set(**bounds)
    draw_lumps(axes, lumps)
    draw_findings(axes, findings)
    return figure


def cutout_figure(tactile_map: TactileMap, quantity: str, finding: Mapping[str, Any], width_m: float) -> Figure | None:
    """Draw the map around one finding, `width_m` (m) wide.

    Returns None if the quantity was never felt or the finding has no place.
    """
    shown = picture(tactile_map, quantity)
    if shown is None or finding.get("x_m") is None or finding.get("y_m") is None:
        return None
    figure, axes = _one_map((4.0, 3.3))
    draw_map(axes, tactile_map, quantity, shown)
    draw_stale(axes, tactile_map)
    x, y, half = 1e3 * float(finding["x_m"]), 1e3 * float(finding["y_m"]), 500.0 * width_m
    axes.set(xlim=(x - half, x + half), ylim=(y - half, y + half))
    draw_findings(axes, [finding])
    return figure


def _one_map(size_in: tuple[float, float]) -> tuple[Figure, Axes]:
    """Return a figure with room for a scale at the right."""
    figure = Figure(figsize=size_in)
    width_in, height_in = size_in
    room = {"left": _LEFT_IN / width_in, "right": 1.0 - _RIGHT_IN / width_in}
    axes = figure.subplots(gridspec_kw={**room, "bottom": _BELOW_IN / height_in, "top": 1.0 - _ABOVE_IN / height_in})
    return figure, axes


def draw_map(axes: Axes, tactile_map: TactileMap, quantity: str, shown: MapPicture) -> None:
    """Draw the cells with their scale or, for materials, with a legend of their names."""
    legend = (0.0, 1.0) if quantity == "material" else tactile_map.legend(quantity)
    draw_cells(axes, quantity, shown, legend)
    if quantity != "material":
        draw_scale(axes, quantity, legend)
        return
    for place in range(len(tactile_map.materials)):
        rows, columns = np.nonzero(shown.value[2::6, 2::6] == place)
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            x, y = shown.left_m + CELL_M * (6 * column + 2.5), shown.near_m + CELL_M * (6 * row + 2.5)
            how: dict[str, Any] = {"fontsize": 6, "ha": "center", "va": "center", "path_effects": [_EDGE]}
            axes.text(1e3 * x, 1e3 * y, _letter(place), color="white", clip_on=True, **how)
    colour = [*colours.MATERIALS, colours.OTHER_MATERIAL]
    keys = [
        Patch(
            facecolor="#" + colour[min(place, len(colour) - 1)],
            label=fill(f"{_letter(place)} {named(name)}", _KEY_LETTERS),
        )
        for place, name in enumerate(tactile_map.materials)
    ]
    axes.legend(
        handles=keys, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, fontsize=7.5, handlelength=1.0
    )


def _letter(place: int) -> str:
    return chr(ord("A") + place % 26)


def _bounds(tactile_map: TactileMap) -> dict[str, tuple[float, float]]:
    """Return axis limits that the maps of all quantities share, mm."""
    edges = []
    for quantity in QUANTITIES:
        shown = picture(tactile_map, quantity)
        if shown is None:
            continue
        rows, columns = np.nonzero(~np.isnan(shown.value))
        low_x, low_y = shown.left_m + CELL_M * columns.min(), shown.near_m + CELL_M * rows.min()
        high_x, high_y = shown.left_m + CELL_M * (columns.max() + 1), shown.near_m + CELL_M * (rows.max() + 1)
        edges.append((low_x - _MARGIN_M, high_x + _MARGIN_M, low_y - _MARGIN_M, high_y + _MARGIN_M))
    low, high = (1e3 * np.min(edges, axis=0)).tolist(), (1e3 * np.max(edges, axis=0)).tolist()
    return {"xlim": (low[0], high[1]), "ylim": (low[2], high[3])}
