"""Figure of the paper's repeated figures: motor speed, skin layers, and thermal identification over time."""

from collections.abc import Mapping
from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from common.limits import MOTOR_FLOOR_RPM
from common.wire.messages import ExplorationMode
from studies.drawing import Data, Rows, curve, figure_file, log_axes, where
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, MODE_COLOURS, ORANGE, PLUM, RED

_OPAQUE: dict[str, Any] = {"frameon": True, "framealpha": 1.0, "edgecolor": "white"}
_LAYERS = {"epidermis": RED, "dermis": ORANGE, "subcutis": BLUE}
_OBJECTS: Mapping[str, Literal["-", "--"]] = {"iron": "-", "wood": "--"}


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    with figure_file(path, 11.5, 12.0) as figure:
        parts = figure.subplot_mosaic([["motor", "motor"], ["usual", "colder"], ["temperature", "rate"]])
        _draw_motor(parts["motor"], data["motor"])
        for start in data["starts"]:
            _draw_layers(parts[start["start"]], data["layers"], start)
        _draw_temperature(parts["temperature"], data)
        _draw_rate(parts["rate"], data)


def _draw_motor(axes: Axes, rows: Rows) -> None:
    highest = 1.12 * max(row["motor_rpm"] for row in rows)
    for mode, group in groupby(rows, key=lambda row: row["mode"]):
        times_s = [row["time_s"] for row in group]
        colour = MODE_COLOURS[ExplorationMode[mode.upper()]]
        axes.axvspan(times_s[0], times_s[-1], color=colour, alpha=0.13, linewidth=0.0)
        middle_s = 0.5 * (times_s[0] + times_s[-1])
        axes.text(middle_s, highest, mode, ha="center", va="top", color="#404040")
    times_s = [row["time_s"] for row in rows]
    axes.plot(times_s, [row["wanted_rpm"] for row in rows], color=GREY, linewidth=1.0, label="wanted")
    axes.plot(times_s, [row["motor_rpm"] for row in rows], color=BLUE, linewidth=1.6, label="simulated motor")
    axes.axhline(MOTOR_FLOOR_RPM, color=BLACK, linestyle=":", linewidth=0.9, label="slower is not felt")
    axes.set(xlim=(times_s[0], times_s[-1]), ylim=(0.0, 1.02 * highest), xlabel="time (s)")
    axes.set(ylabel="speed of the motor (rpm)")
    axes.set_title("Fig. 4: tapping, then stroking PVC with grooves 8 mm apart at 50 mm/s", loc="left")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1)


def _draw_layers(axes: Axes, rows: Rows, start: Mapping[str, Any]) -> None:
    for name, dashes in _OBJECTS.items():
        mine = where(rows, start=start["start"], object=name)
        for layer, colour in _LAYERS.items():
            curve(axes, mine, "time_s", f"{layer}_c", color=colour, linestyle=dashes, linewidth=1.5)
    keys = [Line2D([], [], color=colour, label=layer) for layer, colour in _LAYERS.items()]
    keys += [Line2D([], [], color=BLACK, linestyle=dashes, label=name) for name, dashes in _OBJECTS.items()]
    axes.legend(handles=keys, ncols=2, loc="upper left")
    axes.axvline(0.0, color=GREY, linewidth=0.9, linestyle=":")
    axes.margins(x=0.0, y=0.08)
    axes.set(xlabel="time since contact (s)", ylabel="mean temperature of the layer (°C)")
    axes.set_title(
        f"Fig. 6: from air of 25 °C onto objects of 35 °C; deep tissue {start['deep_c']:.0f} °C,\n"
        f"at the start surface {start['surface_c']:.1f}, epidermis {start['epidermis_c']:.1f} °C",
        loc="left",
    )


def _draw_temperature(axes: Axes, data: Data) -> None:
    rows = data["identification"]
    _curve(axes, rows, "sensor_c", color=GREY, label="sensor's plate")
    _curve(axes, rows, "exponential_object_c", color=RED, label="object, the paper's way")
    known = [row for row in rows if row["object_c"] is not None]
    times_s = [row["time_s"] for row in known]
    low, high = ([row["object_c"] + side * row["object_sd_k"] for row in known] for side in (-1.0, 1.0))
    axes.fill_between(times_s, low, high, color=BLUE, alpha=0.18, linewidth=0.0)
    _curve(axes, rows, "object_c", color=BLUE, label="object, this project, ± 1 SD")
    axes.axhline(data["object_c"], color=BLACK, linestyle="--", linewidth=0.9, label="object, true")
    _mark(axes, data)
    axes.set(ylim=(data["object_c"] - 3.0, max(row["sensor_c"] for row in rows) + 0.5), ylabel="temperature (°C)")
    axes.set_title("Fig. 13: aluminium touched by the remote sensor", loc="left")
    axes.legend(loc="upper right", **_OPAQUE)


def _draw_rate(axes: Axes, data: Data) -> None:
    rows = data["identification"]
    _curve(axes, rows, "exponential_rate_per_s", color=RED, label="rate 1/τ (1/s), the paper's way")
    true = data["effusivity_j_m2ks05"]
    shares = [{"time_s": row["time_s"], "share": _share(row["effusivity_j_m2ks05"], true)} for row in rows]
    _curve(axes, shares, "share", color=BLUE, label="effusivity / true, this project")
    axes.axhline(1.0, color=BLACK, linestyle="--", linewidth=0.9)
    if named := [row for row in rows if row["material"] is not None]:
        axes.axvline(named[0]["time_s"], color=GREEN, linewidth=1.2)
        axes.annotate(
            f"named {named[0]['material']}",
            (named[0]["time_s"], 2.0),
            xytext=(-5, 0),
            textcoords="offset points",
            ha="right",
            color=GREEN,
        )
    _mark(axes, data)
    log_axes(axes, y=(0.1, 0.2, 0.5, 1, 2, 4))
    axes.set(ylim=(0.1, 4.0))
    axes.set_title("Quantities that identify the material", loc="left")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.08), **_OPAQUE)


def _share(value: float | None, true: float) -> float | None:
    return None if value is None else value / true


def _curve(axes: Axes, rows: Rows, column: str, **how: Any) -> None:
    known = [row for row in rows if row[column] is not None]
    curve(axes, known, "time_s", column, linewidth=1.5, **how)


def _mark(axes: Axes, data: Data) -> None:
    """Mark the time at which the paper takes its values."""
    axes.axvline(data["paper_s"], color=PLUM, linestyle=":", linewidth=1.2)
    axes.text(data["paper_s"] + 0.08, 0.02, "paper: 7 s", color=PLUM, transform=axes.get_xaxis_transform())
    axes.set(xlim=(0.0, data["identification"][-1]["time_s"]), xlabel="time since contact (s)")
