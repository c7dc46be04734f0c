"""Figure of tick rates: delay and correctness of live sessions against their cost."""

from pathlib import Path

from matplotlib.axes import Axes

from studies.drawing import Data, curve, figure_file, stacked_bars
from teletaction.plotting.figure_style import BLUE, GREEN, ORANGE, RED

_PROCESSES = {"remote": BLUE, "operator": ORANGE, "sim-remote": GREEN, "sim-operator": RED}


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    with figure_file(path, 11.5, 4.2) as figure:
        delay, cost = figure.subplots(1, 2)
        _delay(delay, data)
        _cost(cost, data)


def _delay(axes: Axes, data: Data) -> None:
    for field, colour, label in (
        ("contact_to_motor_p99_ms", ORANGE, "99 % below"),
        ("contact_to_motor_p50_ms", BLUE, "median"),
    ):
        curve(axes, data["sessions"], "cores", field, marker="o", linestyle="none", color=colour, alpha=0.35, ms=4)
        curve(axes, data["rates"], "cores", field, marker="o", color=colour, label=label)
    for row in data["rates"]:
        axes.annotate(
            row["rates"].replace(",", " / "),
            (row["cores"], row["contact_to_motor_p50_ms"]),
            (0, -13),
            textcoords="offset points",
            ha="center",
        )
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.14)
    axes.set(xlabel=f"processors of {data['processors']}, all processes", ylabel="contact to motor (ms)")
    axes.set_title("Speed against cost; labels: ticks/s, remote / operator site", loc="left")
    axes.legend(loc="lower left")


def _cost(axes: Axes, data: Data) -> None:
    rows = data["rates"]
    names = [row["rates"].replace(",", " /\n") for row in rows]
    parts = {name: ([1e-3 * row[f"{name}_steps_s"] for row in rows], colour) for name, colour in _PROCESSES.items()}
    tops = stacked_bars(axes, names, parts)
    for place, (row, top) in enumerate(zip(rows, tops, strict=True)):
        words = f"{row['on_time']:.2%} on time\n{row['grooves_wrong']} of {row['grooves']}"
        axes.annotate(words, (place, top), (0, 3), textcoords="offset points", ha="center", fontsize=8)
    axes.set_ylim(top=1.25 * max(tops))
    axes.set(xlabel="ticks/s, remote / operator site", ylabel="reference steps a second (1000)")
    axes.set_title("Cost; above: ticks of the least timely process, grooves wrong", loc="left")
    axes.legend(loc="upper left", ncols=2)
