"""Figure of the hundred textures: roughness, names and strangers by time, failures by motion, and quality by bits."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from studies.drawing import WIDEST_IN, Data, curve, draw_panels, log_axes, where
from teletaction.plotting.figure_style import BLUE, GREEN, GREY, ORANGE, PALE, RED, plain_ticks

_SECONDS = (0.15, 0.25, 0.5, 1.0, 2.0, 4.0)
_METHODS = (BLUE, ORANGE, GREEN)
_HALF = 0.5
"""Share of right names below which a stroke counts as too short."""


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    panels = ((draw_roughness, draw_names), (draw_strangers, draw_motion), (draw_similarity, draw_spectra))
    draw_panels(data, path, (WIDEST_IN, 13.0), panels)


def draw_roughness(axes: Axes, data: Data) -> None:
    """Draw the shipped roughness of each texture over the rms of its model."""
    own = np.exp([row["own_ln_rms"] for row in data["strokes"]])
    found = 1e3 * np.exp([row["ln_roughness"] for row in data["strokes"]])
    axes.loglog(own, found, ".", color=BLUE, markersize=3)
    plain_ticks(axes.xaxis, (0.5, 1.0, 2.0, 5.0, 10.0))
    plain_ticks(axes.yaxis, (3.0, 10.0, 30.0, 100.0))
    axes.set(xlabel="the model's own rms (m/s²)", ylabel="roughness (mV)")
    row = data["roughness"]
    title = f"Spearman {row['spearman_five_strokes']:.2f} (5 strokes), {row['spearman_one_stroke']:.2f} (1)"
    axes.set_title(title, loc="left")


def draw_names(axes: Axes, data: Data) -> None:
    """Draw the share of right names by the duration of a stroke; solid first, dashed among three."""
    rows = data["accuracy"]
    methods = list(dict.fromkeys(row["method"] for row in rows))
    shipped = where(rows, method=methods[0])
    short = [row["seconds"] for row in shipped if row["top_1"] < _HALF]
    if short:
        axes.axvspan(min(short), max(short), color=PALE, label="below half right")
    for method, colour in zip(methods, _METHODS, strict=True):
        mine = where(rows, method=method)
        curve(axes, mine, "seconds", "top_1", (1.0, 100.0), color=colour, marker="o", ms=4, label=method)
        curve(axes, mine, "seconds", "top_3", (1.0, 100.0), color=colour, linestyle="--")
    log_axes(axes, _SECONDS)
    axes.set(ylim=(0.0, 118.0), xlabel="stroke (s)", ylabel="right (%)")
    axes.set_title("Five labelled strokes each; dashed: among three", loc="left")
    axes.legend(loc="upper left", fontsize="small")


def draw_strangers(axes: Axes, data: Data) -> None:
    """Draw the shares of strangers and of calibrated textures that are unknown."""
    for known, line in (("many", "-"), ("few", "--")):
        mine = where(data["strangers"], known_textures=known)
        for name, colour, who in (
            ("strange_unknown_share", BLUE, "strangers unknown"),
            ("own_unknown_share", RED, "calibrated ones unknown"),
        ):
            label = f"{who}, {known} calibrated"
            curve(
                axes, mine, "seconds", name, (1.0, 100.0), color=colour, linestyle=line, marker="o", ms=4, label=label
            )
    axes.axhline(80.0, color=GREY, linestyle=":")
    log_axes(axes, _SECONDS)
    axes.set(ylim=(0.0, 100.0), xlabel="stroke (s)", ylabel="strokes (%)")
    axes.set_title("Strangers; dotted: goal", loc="left")
    axes.legend(loc="lower left", fontsize="small")


def draw_motion(axes: Axes, data: Data) -> None:
    """Draw the share of right names after 1 s by quarters of speed and force."""
    rows = data["by_motion"]
    count = 1 + max(row["speed_part"] for row in rows)
    share = np.full((count, count), np.nan)
    for row in rows:
        if row["top_1"] is not None:
            share[row["force_part"], row["speed_part"]] = 100.0 * row["top_1"]
            axes.text(row["speed_part"], row["force_part"], f"{100.0 * row['top_1']:.0f}", ha="center", va="center")
    axes.imshow(share, origin="lower", vmin=0.0, vmax=100.0, cmap="Blues", alpha=0.6, aspect="auto")
    axes.set_xticks(range(count), ["slow", *[""] * (count - 2), "fast"])
    axes.set_yticks(range(count), ["light", *[""] * (count - 2), "firm"])
    axes.grid(visible=False)
    axes.set_title("Right after 1 s (%), quarters of speed and force", loc="left")


def draw_similarity(axes: Axes, data: Data) -> None:
    """Draw ST-SIM (filled) and SPQI (open) over the bit rate; lines are ways without a link."""
    _draw_quality(axes, data, (("st_sim", "full"), ("spqi", "none")), "similarity (1: equal)")
    axes.set_title("ST-SIM filled, SPQI open", loc="left")


def draw_spectra(axes: Axes, data: Data) -> None:
    """Draw the difference of the spectra over the bit rate; lines are ways without a link."""
    _draw_quality(axes, data, (("off_db", "full"),), "difference of spectra, rms (dB)")
    axes.set_title("Difference in bands; lines: no link", loc="left")


def _draw_quality(axes: Axes, data: Data, columns: tuple[tuple[str, str], ...], label: str) -> None:
    for note in data["without"]:
        axes.text(0.5, 0.5, note, ha="center", transform=axes.transAxes, fontsize="small")
    rows = data["quality"]
    sent = [row for row in rows if row["bits_s"] is not None]
    ways = list(dict.fromkeys(row["way"] for row in sent))
    for way, colour in zip(ways, (BLUE, GREEN, RED), strict=False):
        for column, filled in columns:
            how = {"color": colour, "marker": "o", "fillstyle": filled, "label": way if filled == "full" else None}
            curve(axes, where(sent, way=way), "bits_s", column, (1e-3, 1.0), **how)
    for row, dashes in zip([row for row in rows if row["bits_s"] is None], ("-", "--", ":"), strict=False):
        for column, filled in columns:
            colour = GREY if filled == "full" else PALE
            axes.axhline(row[column], color=colour, linestyle=dashes, label=row["way"] if filled == "full" else None)
    log_axes(axes, (0.1, 1.0, 10.0))
    axes.set(xlabel="bit rate (kbit/s)", ylabel=label)
    if rows:
        axes.legend(fontsize="x-small")
