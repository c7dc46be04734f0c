"""Panels of the study of exploration modes: time in the right mode against noise, latency of switches, tap speed."""

from pathlib import Path

from matplotlib.axes import Axes

from studies.drawing import WIDEST_IN, Data, curve, draw_panels, log_axes, named_lines, where
from studies.exploration_modes.judge import JUDGED, MACHINE, PLAIN
from teletaction.plotting.figure_style import BLUE, GREY, PALE, RED, plain_ticks

_COLOURS = {MACHINE: BLUE, PLAIN: RED}
_SWITCHES = ("contact", "end of the tap", "stroke begins", "stroke ends", "release")


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    draw_panels(data, path, (WIDEST_IN, 4.5), ((draw_time_right, draw_latencies, draw_tap_speeds),))


def draw_time_right(axes: Axes, data: Data) -> None:
    """Share of the time in the right mode against the noise; the numbers are wrong switches, %."""
    for method, colour in _COLOURS.items():
        rows = where(data["levels"], method=method)
        curve(axes, rows, "noise", "right", (1.0, 100.0), color=colour, marker="o", label=method)
        for row in rows:
            axes.annotate(
                f"{100 * row['wrong_switches'] / row['switches']:.1f}",
                (row["noise"], 100 * row["right"]),
                (0, 6),
                textcoords="offset points",
                ha="center",
                fontsize=7,
                color=colour,
            )
    axes.axhline(98.0, color=GREY, linestyle=":")
    axes.axvspan(0.75, JUDGED, color=PALE, zorder=0)
    log_axes(axes, sorted({row["noise"] for row in data["levels"]}))
    axes.set(xlim=(0.75, 13.0), ylim=(None, 101.5), xlabel="noise / nominal", ylabel="time in the right mode (%)")
    axes.set_title("Modes; numbers: % of switches that were wrong", loc="left")
    axes.legend(loc="lower left")


def draw_latencies(axes: Axes, data: Data) -> None:
    """Latency of reported switches at three times the noise: median, 5 to 95 %."""
    for method, shift in ((MACHINE, -0.15), (PLAIN, 0.15)):
        for place, name in enumerate(_SWITCHES):
            for row in where(data["latencies"], method=method, noise=JUDGED, switch=name):
                low, middle, high = (1e3 * row[at] for at in ("p5_s", "p50_s", "p95_s"))
                axes.plot([low, high], [place + shift] * 2, color=_COLOURS[method], linewidth=2.0)
                axes.plot(middle, place + shift, "o", color=_COLOURS[method], label=None if place else method)
    axes.axvline(5.0, color=GREY, linestyle=":")
    axes.set_xscale("symlog", linthresh=10.0)
    plain_ticks(axes.xaxis, (-100, -10, -5, 0, 5, 10, 100, 400))
    named_lines(axes, _SWITCHES)
    axes.set_xlabel("reported after it was true (ms)")
    axes.set_title("Latency; dots: median, lines: 5 to 95 %", loc="left")
    axes.legend(loc="lower right")


def draw_tap_speeds(axes: Axes, data: Data) -> None:
    """Error of the approach speed of taps against the speed."""
    for method, colour in _COLOURS.items():
        for noise, line in ((1.0, "--"), (JUDGED, "-")):
            rows = where(data["taps"], method=method, noise=noise)
            speeds_mm_s = [1e3 * (row["from_m_s"] * row["to_m_s"]) ** 0.5 for row in rows]
            errors, label = [100 * row["p95"] for row in rows], f"{method}, noise x {noise:g}"
            axes.plot(speeds_mm_s, errors, color=colour, linestyle=line, marker="o", label=label)
    log_axes(axes, (20, 50, 100, 200))
    axes.set(ylim=(0.0, None), xlabel="approach speed (mm/s)", ylabel="error, 95 % of the taps (%)")
    axes.set_title("Taps: speed before the impact", loc="left")
    axes.legend()
