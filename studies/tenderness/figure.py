"""Figure of tenderness: errors of the centre, presses above the threshold, and reaction times."""

from pathlib import Path

from matplotlib.axes import Axes

from studies.drawing import Data, draw_panels, named_lines, where
from teletaction.plotting.figure_style import BLUE, GREY


def plot(data: Data, path: Path) -> None:
    """Draw the data of the study, and write the figure as PNG."""
    draw_panels(data, path, (11.0, 7.0), ((draw_errors, draw_exceeded), (draw_reactions, draw_thresholds)))


def draw_errors(axes: Axes, data: Data) -> None:
    """Draw each patient's distance between found and true centre, a line for each condition."""
    names = [row["condition"] for row in data["conditions"]]
    for line, row in enumerate(data["conditions"]):
        found = [each["place_error_mm"] for each in where(data["patients"], condition=row["condition"])]
        known = [error for error in found if error is not None]
        axes.plot(known, [line] * len(known), "|", color=BLUE, markersize=8)
        axes.text(1.01, line, f"{100 * row['within_goal']:.0f} %", transform=axes.get_yaxis_transform(), va="center")
    axes.axvline(data["goal"]["place_mm"], color=GREY)
    named_lines(axes, names)
    axes.set(xlabel="distance of the found centre (mm); right: share within the goal")


def draw_exceeded(axes: Axes, data: Data) -> None:
    """Draw the share of presses after the first report that exceed the threshold, for each condition."""
    rows = data["conditions"]
    axes.barh(range(len(rows)), [100.0 * row["exceeded"] for row in rows], color=BLUE)
    axes.axvline(100.0 * data["goal"]["exceeded"], color=GREY)
    named_lines(axes, [row["condition"] for row in rows])
    axes.set(xlabel="presses above the threshold after the first report (%)")


def draw_reactions(axes: Axes, data: Data) -> None:
    """Draw found over true reaction times of the usual patients."""
    rows = where(data["patients"], condition="usual")
    axes.plot([0.3, 1.2], [0.3, 1.2], color=GREY)
    true_s, found_s, sd_s = (
        [row[name] for row in rows] for name in ("reaction_s", "found_reaction_s", "reaction_sd_s")
    )
    axes.errorbar(true_s, found_s, sd_s, fmt="o", color=BLUE, markersize=3, linewidth=0.6)
    axes.set(xlabel="reaction time (s)", ylabel="found reaction time (s)")


def draw_thresholds(axes: Axes, data: Data) -> None:
    """Draw found over true thresholds at the centre of the usual patients."""
    rows = [row for row in where(data["patients"], condition="usual") if row["found_threshold_n"] is not None]
    axes.plot([1.0, 3.0], [1.0, 3.0], color=GREY)
    axes.plot(*([row[name] for row in rows] for name in ("threshold_n", "found_threshold_n")), "o", color=BLUE, ms=3)
    axes.set(xlabel="threshold at the centre (N)", ylabel="found threshold (N)")
