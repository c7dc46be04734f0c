"""Figure of the study of surface identification: presses, jitter, breathing surfaces, and a nodule."""

from pathlib import Path

from matplotlib.axes import Axes

from studies.drawing import WIDEST_IN, Data, curve, draw_panels, log_axes, where
from teletaction.plotting.figure_style import BLUE, GREEN, GREY, ORANGE, RED

_COLOURS = {"12 bits": BLUE, "CAN frames": ORANGE}
_AGAIN = (BLUE, ORANGE, GREEN, RED)
_JND = 0.23


def plot(data: Data, path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    panels = ((draw_errors, draw_jitter), (draw_breath, draw_nodule), (draw_known, draw_wrong))
    draw_panels(data, path, (WIDEST_IN, 11.0), panels)


def draw_errors(axes: Axes, data: Data) -> None:
    """Draw the stiffness error after one press, by stiffness: the worst and the median of each force range."""
    for steps, colour in _COLOURS.items():
        rows = where(data["presses"], steps=steps)
        shift = 0.97 if steps == "12 bits" else 1.03
        for name, marker, label in (("error_most", "v", "worst"), ("error_p50", "o", "median")):
            how = {"color": colour, "marker": marker, "markersize": 5, "label": f"{label}, {steps}"}
            curve(axes, rows, "stiffness_n_m", name, (shift, 100.0), linestyle="", **how)
    for percent, name, line in ((15.0, "wanted", ":"), (100 * _JND, "JND", "--")):
        axes.axhline(percent, color=GREY, linestyle=line)
        axes.text(100.0, 1.04 * percent, name, color=GREY, fontsize=8)
    log_axes(axes, sorted({row["stiffness_n_m"] for row in data["presses"]}), (0.1, 0.3, 1, 3, 10, 30))
    axes.set(ylim=(0.05, 35.0), xlabel="stiffness (N/m)", ylabel="error after one press (%)")
    axes.set_title("One press of 2 to 5 N; a mark for each 1 N of force", loc="left")
    axes.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, -0.02))


def draw_jitter(axes: Axes, data: Data) -> None:
    """Draw the jitter of the surface under a resting finger, raw and identified, against the wall's stiffness."""
    wall_n_m = [row["stiffness_n_m"] for row in data["jitter"]]
    for name, label, colour in (("raw_mm", "z + F/k", RED), ("told_mm", "identified", BLUE)):
        curve(axes, data["jitter"], "stiffness_n_m", name, color=colour, marker="o", label=label)
    axes.axhline(0.05, color=GREY, linestyle=":")
    log_axes(axes, wall_n_m, (0.001, 0.003, 0.01, 0.03, 0.1, 0.3))
    axes.set(xlabel="stiffness of the wall (N/m)", ylabel="standard deviation (mm)")
    axes.set_title("Surface under a finger at rest", loc="left")
    axes.legend()


def draw_breath(axes: Axes, data: Data) -> None:
    """Draw the height of a breathing surface, true and identified, over time."""
    course = data["courses"]["breath"]
    axes.plot(course["along"], course["true_mm"], color=GREY, linewidth=2.5, label="true")
    axes.plot(course["along"], course["told_mm"], color=BLUE, label="identified")
    row = next(row for row in data["moving"] if row["stiffness_n_m"] == 500.0)
    axes.set(ylim=(-1.6, 1.6), xlabel="time (s)", ylabel="height of the surface (mm)")
    axes.set_title(f"500 N/m, breathing by {row['moves']}; identified {row['lag_ms']:.0f} ms late", loc="left")
    axes.legend(loc="upper right")


def draw_nodule(axes: Axes, data: Data) -> None:
    """Draw the stiffness along a stroke over a nodule, true and identified."""
    course = data["courses"]["nodule"]
    axes.plot(course["along"], course["true_n_m"], color=GREY, linewidth=2.5, label="true")
    axes.plot(course["along"], course["told_n_m"], color=BLUE, label="identified")
    axes.set(ylim=(0.0, None), xlabel="distance along the stroke (mm), at 30 mm/s", ylabel="stiffness (N/m)")
    axes.set_title("From tissue over a nodule with edges of 2 mm", loc="left")
    axes.legend(loc="upper right")


def draw_known(axes: Axes, data: Data) -> None:
    """Draw the share of contacts whose stiffness is known, over time, while presses follow each other."""
    _draw_again(axes, data, "known")
    axes.set(ylim=(-2.0, 102.0), ylabel="stiffness known (%)")
    axes.set_title("Pressed again and again, on a surface that breathes", loc="left")


def draw_wrong(axes: Axes, data: Data) -> None:
    """Draw the share of contacts whose stiffness is known and more than 15 % wrong, over time."""
    _draw_again(axes, data, "known_and_wrong")
    axes.set(ylim=(-0.5, None), ylabel="known, and more than 15 % wrong (%)")
    axes.set_title("The same contacts", loc="left")
    axes.legend(loc="upper right")


def _draw_again(axes: Axes, data: Data, column: str) -> None:
    rows = data["again_by_time"]
    for stiffness_n_m, colour in zip(sorted({row["stiffness_n_m"] for row in rows}), _AGAIN, strict=True):
        shown = {"color": colour, "marker": "o", "markersize": 3, "label": f"{stiffness_n_m:g} N/m"}
        curve(axes, where(rows, breathes=True, stiffness_n_m=stiffness_n_m), "to_s", column, (1.0, 100.0), **shown)
    resting = where(rows, breathes=False, stiffness_n_m=500.0)
    curve(axes, resting, "to_s", column, (1.0, 100.0), color=GREY, linestyle="--", label="500 N/m, at rest")
    axes.set(xlabel="end of each second (s)")
