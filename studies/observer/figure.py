"""Figure of the observer's study: felt temperature, objects distinguished, dependencies, and surfaces matched."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from studies.drawing import WIDEST_IN, Data, Rows, curve, figure_file, named_lines, where
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, PALE, PLUM, RED, SKY

_OBJECTS = {"aluminium": BLUE, "ceramic": GREEN, "pvc": ORANGE, "wood": RED}
_SIDES: Mapping[str, Literal["-", "--", ":"]] = {"real": "-", "virtual": "--", "remote": ":"}
_MARKS = {
    "real": (BLACK, "o"),
    "virtual": (BLUE, "s"),
    "virtual, known ahead": (SKY, "D"),
    "remote": (RED, "^"),
}
_PAIRS = {"a-w": (BLUE, "o"), "a-p": (GREEN, "s"), "c-w": (ORANGE, "^"), "p-w": (RED, "D")}
_MATCHED = (
    ("virtual", "set by hand", "features set by hand", GREY, "o"),
    ("virtual", "measured", "virtual, measured", BLUE, "s"),
    ("remote", "measured", "remote, measured", RED, "^"),
    ("virtual", "motor left to itself", "virtual, motor left to itself", SKY, "v"),
    ("virtual", "stroked at 30 mm/s", "virtual, stroked at 30 mm/s", GREEN, "D"),
    ("virtual", "foam with its own stiffness", "virtual, foam is soft", PLUM, "*"),
    ("virtual", "constants by roughness, 30 mm/s", "virtual, by roughness, 30 mm/s", ORANGE, "P"),
)
_USUAL_S = 3.0


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    with figure_file(path, WIDEST_IN, 10.0) as figure:
        (courses, answers), (ablations, matching) = figure.subplots(2, 2)
        _draw_courses(courses, data["courses"])
        _draw_answers(answers, data["answers"])
        _draw_ablations(ablations, data["ablations"])
        _draw_matching(matching, data["matching"])


def _draw_courses(axes: Axes, rows: Rows) -> None:
    for name, colour in _OBJECTS.items():
        for side, dashes in _SIDES.items():
            mine = where(rows, object=name, side=side)
            width = 1.8 if side == "remote" else 1.3
            curve(axes, mine, "time_s", "change_k", color=colour, linestyle=dashes, linewidth=width)
    keys = [Line2D([], [], color=colour, label=name) for name, colour in _OBJECTS.items()]
    keys += [Line2D([], [], color=BLACK, linestyle=dashes, label=side) for side, dashes in _SIDES.items()]
    axes.legend(handles=keys, ncols=2, loc="lower left")
    axes.axvline(_USUAL_S, color=GREY, linewidth=0.9, linestyle=(0, (1, 3)))
    axes.set_xlim(0.0, max(row["time_s"] for row in rows))
    axes.set(xlabel="time in contact (s)", ylabel="change of the felt temperature (K)")
    axes.set_title("Objects at 25 °C at the simulated fingertip", loc="left")


def _draw_answers(axes: Axes, rows: Rows) -> None:
    colder = where(rows, first_is_felt="colder", dwell_s=_USUAL_S)
    pairs = list(dict.fromkeys(row["pair"] for row in colder))
    width = 0.19
    for number, (side, (colour, mark)) in enumerate(_MARKS.items()):
        shift = (number - 0.5 * (len(_MARKS) - 1)) * width
        for place, pair in enumerate(pairs):
            (row,) = (row for row in colder if row["side"] == side and row["pair"] == pair)
            if row["paper_count"] is not None:
                _draw_paper(axes, place + shift, row, 0.85 * width, 0.84 * width)
            label = side if place == 0 else None
            axes.plot(place + shift, row["predicted_percent"], mark, color=colour, ms=7, zorder=3, label=label)
    axes.set_xticks(range(len(pairs)), pairs)
    axes.grid(visible=False, axis="x")
    axes.set(ylim=(0.0, 104.0), ylabel="first object is felt colder (% of answers)")
    axes.set_title(f"Table 2 after {_USUAL_S:g} s; grey: the paper's share and its 95 % interval", loc="left")
    axes.legend(loc="lower left")


def _draw_paper(axes: Axes, place: float, row: Mapping[str, Any], width: float, line: float) -> None:
    """Draw the paper's share as a line on its interval."""
    low, high = row["interval_low_percent"], row["interval_high_percent"]
    axes.bar(place, high - low, width, bottom=low, color=PALE, zorder=1)
    axes.hlines(row["paper_percent"], place - 0.5 * line, place + 0.5 * line, color=GREY, lw=2)


def _draw_ablations(axes: Axes, rows: Rows) -> None:
    cases = list(dict.fromkeys((row["varied"], row["value"]) for row in rows))
    for place, case in enumerate(cases):
        for pair, (colour, mark) in _PAIRS.items():
            for row in rows:
                if (row["varied"], row["value"]) == case and row["pair"] == pair:
                    real = row["side"] == "real"
                    at = place + (-0.15 if real else 0.15)
                    face = colour if real else "none"
                    axes.plot(row["colder_percent"], at, mark, color=colour, mfc=face, ms=6, mew=1.4)
    names = [f"{varied} {value}".strip() for varied, value in cases]
    named_lines(axes, names)
    axes.set(xlim=(0.0, 100.0), xlabel="first object is felt colder (% of answers)")
    axes.set_title("What it depends on, after 3 s; filled: real, open: ideal plate", loc="left")
    keys = [
        Line2D([], [], color=colour, marker=mark, linestyle="none", label=pair)
        for pair, (colour, mark) in _PAIRS.items()
    ]
    axes.legend(handles=keys, loc="lower left")


def _draw_matching(axes: Axes, rows: Rows) -> None:
    surfaces = list(dict.fromkeys(row["surface"] for row in rows))
    for place, surface in enumerate(surfaces):
        row = next(row for row in rows if row["surface"] == surface)
        _draw_paper(axes, place, row, 0.8, 0.8)
    for number, (side, features, label, colour, mark) in enumerate(_MATCHED):
        shift = (number - 0.5 * (len(_MATCHED) - 1)) * 0.12
        mine = {row["surface"]: row for row in rows if row["side"] == side and row["features"] == features}
        shares = [mine[surface]["predicted_percent"] for surface in surfaces]
        size = 11 if mark == "*" else 6.5
        axes.plot([place + shift for place in range(len(surfaces))], shares, mark, color=colour, ms=size, label=label)
    axes.axhline(100.0 / len(surfaces), color=GREY, linestyle=":", linewidth=0.9)
    axes.set_xticks(range(len(surfaces)), [name.replace("_pvc", "").replace("_", "\n") for name in surfaces])
    axes.grid(visible=False, axis="x")
    axes.set_ylim(0.0, 142.0)
    axes.set_yticks(range(0, 101, 20))
    axes.set_ylabel("matched (%)")
    axes.set_title("Table 1; grey: the paper's, with its 95 % interval; dotted: chance", loc="left")
    axes.legend(loc="upper left", ncols=2)
