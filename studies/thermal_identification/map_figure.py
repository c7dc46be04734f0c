"""Draws maps of the failures of thermal identification: a cell per condition and time, coloured by the right share."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.patches import Patch

from common.wire.messages import ThermalStatus
from studies.drawing import Rows, named_lines, share_map, where
from teletaction.plotting.figure_style import BLACK, GREEN, GREY, ORANGE, RED, STATUS_COLOURS

_LEVELS = (0.0, 0.1, 0.5, 0.8, 0.95, 1.01)
_COLOURS = ("#7A1E00", ORANGE, "#F9DDB1", "#BFE3D5", GREEN)
_NAMES = ("< 10 %", "10-50 %", "50-80 %", "80-95 %", ">= 95 % likeliest is right")
_PERCENT = 100.0
_KINDS = (
    ("right", GREEN, "named right"),
    ("wrong", RED, "named wrong"),
    ("ambiguous", STATUS_COLOURS[ThermalStatus.AMBIGUOUS], "ambiguous"),
    ("deciding", STATUS_COLOURS[ThermalStatus.DECIDING], "deciding"),
    ("unknown", STATUS_COLOURS[ThermalStatus.UNKNOWN], "unknown"),
    ("unidentifiable", STATUS_COLOURS[ThermalStatus.UNIDENTIFIABLE], "unidentifiable"),
)


def map_keys() -> list[Patch]:
    """Return the legend entries of the maps and of the bars."""
    cells = [Patch(facecolor=colour, edgecolor=GREY, label=name) for colour, name in zip(_COLOURS, _NAMES, strict=True)]
    return cells + [Patch(facecolor=colour, label=f"bar: {name}") for _, colour, name in _KINDS]


def draw_differences(places: Sequence[Axes], rows: Rows) -> None:
    """Draw difference x time, a map for each noise."""
    noises = sorted({row["noise_k"] for row in rows})
    for axes, noise_k in zip(places, noises, strict=True):
        _draw_map(axes, where(rows, noise_k=noise_k), "difference_k")
        axes.set_title(f"noise {noise_k * 1e3:g} mK", loc="left")
    places[0].set_ylabel("plate minus object (K)")


def draw_spread(axes: Axes, rows: Rows) -> None:
    """Draw spread of the contact conductance x time."""
    _draw_map(axes, rows, "contact_spread")
    axes.set_ylabel("sd of ln(contact conductance)")
    axes.set_title("contacts that scatter (calibrated with 0.15)", loc="left")


def draw_changes(axes: Axes, rows: Rows) -> None:
    """Draw bars of the answers at the end of touches whose contact changed."""
    end_s = max((row["t_s"] for row in rows), default=0.0)
    last = where(rows, t_s=end_s)
    labels = [
        f"lifted at {row['change_s']:g} s"
        if row["force_share"] == 0.0
        else f"force x {row['force_share']:g} at {row['change_s']:g} s"
        for row in last
    ]
    _draw_bars(axes, last, labels)
    axes.set_title(f"contact that changes: answers at {end_s:g} s", loc="left")


def draw_untrained(axes: Axes, rows: Rows) -> None:
    """Draw bars of the answers to uncalibrated materials, by distance, with the share ever named."""
    end_s = max((row["t_s"] for row in rows), default=0.0)
    last = sorted((row for row in rows if row["t_s"] == end_s), key=lambda row: abs(row["away_ln"]))
    _draw_bars(axes, last, [f"{row['material']} {row['away_ln']:+.2f}" for row in last])
    for place, row in enumerate(last):
        if row["named"] > 0.0:
            axes.text(101.0, place, f"{_PERCENT * row['named']:.0f} %", va="center", fontsize=8, color=RED)
    axes.set_title(f"untrained, by distance in ln e: answers at {end_s:g} s\n(red: ever named as another)", loc="left")


def _draw_map(axes: Axes, rows: Rows, varied: str) -> None:
    share_map(axes, rows, ("t_s", varied, "right"), _LEVELS, _COLOURS)
    values, times = sorted({row[varied] for row in rows}), sorted({row["t_s"] for row in rows})
    for row in rows:
        place = values.index(row[varied]), times.index(row["t_s"])
        _write(axes, place, row["identified"] - row["wrong"], BLACK, 0.0)
        _write(axes, place, row["wrong"], RED, 0.28)
    axes.set_xlabel("time after contact (s)")


def _write(axes: Axes, place: tuple[int, int], share: float, colour: str, aside: float) -> None:
    """Write a share in per cent into a cell, unless it is 0."""
    if share > 0.0:
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}
        x, y = place[1] + 0.5 + aside, place[0] + 0.5
        text = f"{_PERCENT * share:.0f}"
        axes.text(x, y, text, color=colour, bbox=box, ha="center", va="center", fontsize=7.5, fontweight="bold")


def _draw_bars(axes: Axes, rows: Rows, labels: Sequence[str]) -> None:
    for place, row in enumerate(rows):
        start = 0.0
        for kind, colour, _ in _KINDS:
            share = row["identified"] - row["wrong"] if kind == "right" else row[kind]
            axes.barh(place, _PERCENT * share, left=start, color=colour, height=0.75)
            start += _PERCENT * share
    named_lines(axes, labels, fontsize=8)
    axes.set(xlim=(0.0, 100.0), xlabel="share of touches (%)")
    axes.grid(axis="y", visible=False)
