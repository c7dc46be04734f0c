"""Writes a tactile map as `map.csv`, `map.json` and `map.png`."""

import csv
import json
from collections.abc import Iterator
from io import TextIOWrapper
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from common.files.private_file import create_private, replacing, write_private
from operator_site.console.map.lump_areas import LUMP, Cells, cells, lumps_in, searched
from operator_site.console.map.map_tiles import MapPicture, confidence_of, picture
from operator_site.console.map.tactile_map import TactileMap
from teletaction.mapping.map_recorded import MappedPresses
from teletaction.mapping.nodules import next_mm, nodule_at
from teletaction.plotting.figure_style import BLACK, STYLE
from teletaction.report.map_figure import draw_cells, draw_map, draw_scale

COLUMNS = ("x_mm", "y_mm", "value", "sd", "lump_probability")
"""Columns of `map.csv`: middle of the cell, mm; stiffness and its standard deviation, N/m; probability, 0..1."""
FILES = ("map.csv", "map.json", "map.png")
"""Names of the files of a map."""
_HEIGHT_IN = 4.4
_WIDTH_IN = 5.4


def write_map(mapped: MappedPresses, out: Path, probe_radius_m: float) -> dict[str, Any]:
    """Write the three files into a folder; return the content of `map.json`.

    Args:
        mapped: the map and its presses.
        out: the folder; it is made if it does not exist.
        probe_radius_m: radius of the probe or fingertip, m.

    Raises:
        OSError: a file cannot be written.
    """
    out.mkdir(parents=True, exist_ok=True)
    stiffness = mapped.surface.stiffness
    shown = None if stiffness.field is None else cells(stiffness.field, searched(stiffness.field))
    with (
        replacing(out / "map.csv") as made,
        create_private(made, replace=True) as file,
        TextIOWrapper(file, "utf-8", newline="") as text,
    ):
        writer = csv.writer(text)
        writer.writerow(COLUMNS)
        if shown is not None:
            writer.writerows(_rows(shown))
    summary = _summary(mapped, shown, probe_radius_m)
    write_private(out / "map.json", json.dumps(summary, indent=1, allow_nan=False).encode() + b"\n")
    _draw(mapped, shown, summary, out / "map.png")
    return summary


def _rows(shown: Cells) -> Iterator[tuple[str, ...]]:
    for row, column in np.argwhere(np.isfinite(shown.value)):
        lump = shown.lump[row, column]
        yield (
            f"{shown.x_mm[column]:.1f}",
            f"{shown.y_mm[row]:.1f}",
            f"{shown.value[row, column]:.6g}",
            f"{shown.sd[row, column]:.4g}",
            "" if np.isnan(lump) else f"{lump:.4f}",
        )


def _summary(mapped: MappedPresses, shown: Cells | None, probe_radius_m: float) -> dict[str, Any]:
    surface, field, lumps = mapped.surface, mapped.surface.stiffness.field, mapped.surface.stiffness.lumps
    return {
        "presses": len(mapped.used) + len(mapped.skipped),
        "used": len(mapped.used),
        "skipped": mapped.skipped,
        "quantities": [
            name for name, layer in surface.layers.items() if any(tile.samples for tile in layer.tiles.values())
        ],
        "field_sd_ln": None if field is None else field.field_sd,
        "press_sd_ln": None if field is None else field.press_sd,
        "ground_spread_ln": None if lumps is None else round(lumps.spread, 4),
        "lumps": [
            lump | {"nodule": nodule_at(mapped, lump, probe_radius_m)}
            for lump in ([] if shown is None or field is None else lumps_in(shown, field))
        ],
        "next_press_mm": next_mm(mapped),
    }


def _draw(mapped: MappedPresses, shown: Cells | None, summary: dict[str, Any], path: Path) -> None:
    others = [name for name in summary["quantities"] if name != "stiffness"]
    panels = 2 * (shown is not None) + len(others)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH_IN * panels, _HEIGHT_IN))
        FigureCanvasAgg(figure)
        axes = list(np.atleast_1d(figure.subplots(1, panels, gridspec_kw={"wspace": 0.5})))
        if shown is not None:
            _draw_stiffness(axes.pop(0), mapped, shown)
            _draw_lumps(axes.pop(0), shown, summary)
        for name, one in zip(others, axes, strict=True):
            _draw_layer(one, mapped.surface, name)
        with replacing(path) as made, create_private(made, replace=True) as file:
            figure.savefig(file, format="png", dpi=130, bbox_inches="tight")


def _draw_stiffness(axes: Axes, mapped: MappedPresses, shown: Cells) -> None:
    known = shown.value[np.isfinite(shown.value)]
    low, high = float(np.quantile(known, 0.01)), float(np.quantile(known, 0.995))
    legend = low / 1.05, max(high, 1.1 * low) * 1.05
    relative = np.where(np.isfinite(shown.value), shown.sd / shown.value, np.inf)
    whole = MapPicture(
        1e-3 * float(shown.x_mm[0]) - 0.5e-3,
        1e-3 * float(shown.y_mm[0]) - 0.5e-3,
        shown.value,
        confidence_of("stiffness", relative),
        np.zeros(shown.value.shape, dtype=np.bool_),
    )
    draw_cells(axes, "stiffness", whole, legend)
    draw_scale(axes, "stiffness", legend)
    axes.plot(*mapped.places_mm.T, ".", color=BLACK, markersize=2.0)
    axes.set_title("stiffness, N/m (dots: presses)", loc="left")


def _draw_lumps(axes: Axes, shown: Cells, summary: dict[str, Any]) -> None:
    half = 0.5
    extent = (shown.x_mm[0] - half, shown.x_mm[-1] + half, shown.y_mm[0] - half, shown.y_mm[-1] + half)
    image = axes.imshow(shown.lump, origin="lower", extent=extent, vmin=0.0, vmax=1.0, cmap="Greys")
    if np.isfinite(shown.lump).any() and min(shown.lump.shape) > 1:
        axes.contour(shown.x_mm, shown.y_mm, np.nan_to_num(shown.lump), levels=[LUMP], colors="#A23B7C")
    for lump in summary["lumps"]:
        axes.annotate(f"{lump['probability']:.2f}", (lump["x_mm"], lump["y_mm"]), color="#0072B2", ha="center")
    axes.figure.colorbar(image, ax=axes, shrink=0.8)
    axes.grid(visible=False)
    axes.set(xlabel="x, mm", ylabel="y, mm")
    axes.set_title(f"lump probability (outline: {LUMP:g})", loc="left")


def _draw_layer(axes: Axes, surface: TactileMap, quantity: str) -> None:
    shown = picture(surface, quantity)
    if shown is not None:
        draw_map(axes, surface, quantity, shown)
    axes.set_title(quantity, loc="left")
