"""The tactile map drawn: cells over the ground of what was not felt, legends with confidence, findings as numbers."""

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from operator_site.console import colours
from operator_site.console.map_layer import CELL_M
from operator_site.console.tactile_map import LOGARITHMIC

Floats = NDArray[np.float64]
GROUND = "#" + colours.NOT_FELT


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


def cell_colours(quantity: str, value: Floats, confidence: NDArray[np.uint8], legend: tuple[float, float]) -> Floats:
    """Red, green and blue of each cell, 0..1, (rows, columns, 3): the page's colours, on the ground where not felt."""
    known = ~np.isnan(value)
    shown = np.empty((*value.shape, 3))
    shown[:] = _rgb(colours.NOT_FELT)
    for step in range(4):
        mine = known & (confidence == step)
        if quantity == "material":
            place = np.minimum(value[mine], len(colours.MATERIALS)).astype(int)
            shown[mine] = _MATERIALS[step][place]
        else:
            shown[mine] = _TABLES[quantity, step][np.round(255 * on_scale(quantity, value[mine], legend)).astype(int)]
    return shown


def on_scale(quantity: str, value: Floats, legend: tuple[float, float]) -> Floats:
    """Where values stand on a legend, 0..1; those beyond its ends at them."""
    if quantity in LOGARITHMIC:
        value, legend = np.log(value), (np.log(legend[0]), np.log(legend[1]))
    share: Floats = np.clip((value - legend[0]) / (legend[1] - legend[0]), 0.0, 1.0)
    return share


def draw_cells(
    axes: Axes,
    quantity: str,
    value: Floats,
    confidence: NDArray[np.uint8],
    corner_m: tuple[float, float],
    legend: tuple[float, float],
) -> None:
    """Cells of CELL_M from their near left corner, in mm; what was felt badly is a dot."""
    rows, columns = value.shape
    left, near, cell = 1e3 * corner_m[0], 1e3 * corner_m[1], 1e3 * CELL_M
    extent = (left, left + cell * columns, near, near + cell * rows)
    axes.imshow(
        cell_colours(quantity, value, confidence, legend), origin="lower", extent=extent, interpolation="nearest"
    )
    vague = np.argwhere(~np.isnan(value) & (confidence == 0))[:: 2 if value.size < 40_000 else 3]
    axes.plot(
        left + cell * (vague[:, 1] + 0.5), near + cell * (vague[:, 0] + 0.5), ".", color="#000000", markersize=1.0
    )
    axes.set_facecolor(GROUND)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel("x, mm")
    axes.set_ylabel("y, mm")


def draw_scale(axes: Axes, quantity: str, legend: tuple[float, float]) -> None:
    """A legend beside the cells: value upwards, a column for each confidence."""
    scale = axes.inset_axes((1.04, 0.0, 0.09, 1.0))
    upwards = np.linspace(0.0, 1.0, 256)
    strip = np.stack([_TABLES[quantity, step][np.round(255 * upwards).astype(int)] for step in (1, 2, 3)], axis=1)
    scale.imshow(strip, origin="lower", aspect="auto", extent=(0.5, 3.5, 0.0, 1.0))
    ticks = scale_ticks(quantity, legend)
    scale.set_yticks(on_scale(quantity, np.array(ticks), legend).tolist(), [f"{tick:g}" for tick in ticks])
    scale.yaxis.tick_right()
    scale.set_xticks([1, 3], ["½", "sure"], fontsize=7)
    scale.grid(visible=False)


def scale_ticks(quantity: str, legend: tuple[float, float]) -> list[float]:
    """Plain numbers along a scale."""
    low, high = legend
    if quantity not in LOGARITHMIC:
        return [float(tick) for tick in np.arange(np.ceil(low), np.floor(high) + 0.5)]
    steps = [m * 10.0**e for e in range(-6, 7) for m in (1, 2, 5)]
    return [step for step in steps if low * 0.999 <= step <= high * 1.001]
