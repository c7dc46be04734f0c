"""Defines colours, names and fonts of the figures.

The colours are distinct for colour-blind readers (Okabe and Ito's set) and in greyscale.
"""

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from common.fingers import FINGERS
from common.wire.messages import ExplorationMode, ThermalStatus

BLACK, BLUE, SKY, GREEN, ORANGE, RED, PURPLE, GREY = (
    "#000000",
    "#0072B2",
    "#56B4E9",
    "#009E73",
    "#E69F00",
    "#D55E00",
    "#CC79A7",
    "#8A8A8A",
)
PALE, PLUM = "#E3E6EA", "#A23B7C"
FINGER_COLOURS = (ORANGE, BLUE, GREEN, PURPLE, RED)
FINGER_DASHES = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)))
"""Line styles of thumb to little finger. They distinguish the fingers without colour."""
MODE_COLOURS = {
    ExplorationMode.FREE: PALE,
    ExplorationMode.TAPPING: RED,
    ExplorationMode.QUIESCENT: SKY,
    ExplorationMode.STROKING: "#005F46",
}
STATUS_COLOURS = {
    ThermalStatus.DECIDING: SKY,
    ThermalStatus.IDENTIFIED: GREEN,
    ThermalStatus.AMBIGUOUS: ORANGE,
    ThermalStatus.UNKNOWN: PURPLE,
    ThermalStatus.UNIDENTIFIABLE: GREY,
}
STYLE: dict[Any, Any] = {
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.5,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#ECECEC",
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "text.parse_math": False,
    "figure.facecolor": "white",
}
"""Settings for `matplotlib.rc_context`.

Formulas are off because scene names may contain `$`.
"""


def plain_ticks(axis: Axis, values: Sequence[float]) -> None:
    """Label the ticks of a logarithmic axis with plain numbers."""
    axis.set_major_locator(FixedLocator(list(values)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}".lstrip("0") or "0"))
    axis.set_minor_locator(NullLocator())


def absent(axes: Axes, text: str) -> None:
    """Show a text in place of missing curves."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color="#5A5A5A")


def shown_name(name: str, longest: int = 22) -> str:
    """Replace letters that the figures' font lacks, and shorten the name to `longest` letters."""
    plain = "".join(letter if letter.isprintable() and ord(letter) < 0x250 else "?" for letter in name)
    return plain if len(plain) <= longest else plain[: longest - 1] + "…"


def label_once(axes: Axes, **how: Any) -> None:
    """Draw a legend with each label once; draw none without labels."""
    handles, labels = axes.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    if unique:
        axes.legend(list(unique.values()), list(unique), **how)


def mode_keys() -> list[Patch]:
    """Return the legend entries of the modes."""
    return [Patch(facecolor=colour, label=mode.word) for mode, colour in MODE_COLOURS.items()]


def status_keys() -> list[Patch]:
    """Return the legend entries of the thermal statuses."""
    return [Patch(facecolor=colour, label=status.name.lower()) for status, colour in STATUS_COLOURS.items()]


def finger_keys(fingers: tuple[int, ...]) -> list[Line2D]:
    """Return the legend entries of the fingers."""
    return [
        Line2D([], [], color=FINGER_COLOURS[f], linestyle=FINGER_DASHES[f], label=FINGERS[f])  # type: ignore[arg-type]
        for f in fingers
    ]
