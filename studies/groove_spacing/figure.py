"""Figure of the spacing of grooves: its standard deviation against jitter."""

from pathlib import Path

from studies.drawing import Data, curve, figure_file, where
from teletaction.plotting.figure_style import BLUE, RED

_WAYS = {"as they come": RED, "at their time": BLUE}


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG; the legend gives the lag behind the hand."""
    with figure_file(path, 7.0, 4.5) as figure:
        axes = figure.subplots()
        for way, colour in _WAYS.items():
            for loss, marker in ((0.0, "o"), (0.2, "s")):
                mine = where(data["spacing"], way=way, loss=loss)
                behind_ms = f"{mine[0]['behind_ms']:.0f} to {mine[-1]['behind_ms']:.0f}"
                label = f"{way}, {100 * loss:.0f} % lost: {behind_ms} ms behind"
                curve(axes, mine, "jitter_ms", "spacing_sd_mm", color=colour, marker=marker, label=label)
        axes.set(xlabel="jitter of either direction (± ms)", ylabel="standard deviation of spacing (mm)")
        axes.set_ylim(0.0, None)
        axes.set_title(
            f"Grooves {data['grooves_mm']:g} mm apart, stroked at {data['stroke_mm_s']:g} mm/s over a network"
        )
        axes.legend()
