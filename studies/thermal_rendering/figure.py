"""Figure of the study of thermal rendering: models, integrators, plates and strategies, and the whole loop."""

from pathlib import Path

from matplotlib.axes import Axes

from common.limits import PLATE_COOLING_K_S
from studies.drawing import Data, Rows, curve, figure_file, log_axes, where
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, PALE, PLUM, RED, SKY

_COLOURS = (RED, ORANGE, GREEN, PLUM, BLUE, SKY, GREY)
_MARKS = ("o", "s", "^", "D", "v", "P", "X")
_METHODS = {
    "explicit Euler": (RED, "o"),
    "implicit Euler": (ORANGE, "s"),
    "RK45": (PLUM, "^"),
    "LSODA": (BLUE, "D"),
    "BDF": (SKY, "v"),
    "matrix exponential": (BLACK, "*"),
}
_SMALLEST_K, _DIVERGED_K, _BLOWN_UP_K = 1e-9, 30.0, 30.0


def plot(data: Data, path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    with figure_file(path, 11.5, 13.5) as figure:
        (models, integrators), (plate, strategies), (loop, inverse) = figure.subplots(3, 2)
        _draw_models(models, data["models"])
        _draw_integrators(integrators, data["integrators"])
        _draw_rates(plate, data["rates"])
        _draw_strategies(strategies, data["strategies"])
        _draw_loop(loop, data["loop"])
        _draw_inverse(inverse, data["inverse"])


def _draw_models(axes: Axes, rows: Rows) -> None:
    names = list(dict.fromkeys(row["object"] for row in rows))
    models = list(dict.fromkeys(row["model"] for row in sorted(rows, key=lambda row: row["states"])))
    for name, colour, mark in zip(names, _COLOURS, _MARKS, strict=False):
        by_model = {row["model"]: row for row in rows if row["object"] == name}
        shares = [by_model[model]["share_of_tolerance"] for model in models]
        axes.plot(range(len(models)), shares, color=colour, marker=mark, ms=4, label=name)
        for place, model in enumerate(models):
            if by_model[model]["chosen"]:
                axes.plot(place, shares[place], "o", mfc="none", mec=colour, ms=12, mew=1.6)
    axes.axhspan(1.0, 100.0, color=PALE, zorder=0)
    axes.set_xticks(range(len(models)), models, rotation=25, ha="right")
    log_axes(axes, y=(0.01, 0.1, 1, 10))
    axes.set(ylim=(0.01, 60.0), ylabel="worst error / tolerance")
    axes.set_xlabel("cells of epidermis + dermis + subcutis + object")
    axes.set_title("Models; grey: above tolerance; ringed: chosen", loc="left")
    axes.legend(ncols=2, fontsize=8.5)


def _draw_integrators(axes: Axes, rows: Rows) -> None:
    hardest, model = rows[0]["object"], rows[-1]["model"]
    shown = where(rows, object=hardest, model=model)
    for method, (colour, mark) in _METHODS.items():
        mine = where(shown, method=method)
        right = [row for row in mine if row["error_k"] is not None]
        axes.plot(
            [row["products"] for row in right],
            [max(row["error_k"], _SMALLEST_K) for row in right],
            color=colour,
            marker=mark,
            ms=11 if mark == "*" else 5,
            label=method,
        )
        if wrong := [row for row in mine if row["error_k"] is None]:
            axes.plot([row["products"] for row in wrong], [_DIVERGED_K] * len(wrong), "x", color=colour, ms=8, mew=2)
            axes.annotate(
                "diverges at " + ", ".join(f"{1e3 * row['setting']:g}" for row in wrong) + " ms",
                (max(row["products"] for row in wrong), _DIVERGED_K),
                xytext=(10, -3),
                textcoords="offset points",
                fontsize=8.5,
                color=colour,
            )
    log_axes(axes, (1, 10, 100, 1000), (1e-9, 1e-6, 1e-3, 0.1, 1))
    axes.set_ylim(0.3 * _SMALLEST_K, 5.0 * _DIVERGED_K)
    axes.axhline(0.1, color=GREY, linestyle="--", linewidth=0.9)
    axes.set_xlabel("cost of 10 ms, one finger, in bare products for five")
    axes.set_ylabel("largest error of the felt temperature (K)")
    axes.set_title(f"Integrators, {model} on {hardest}", loc="left")
    axes.legend(fontsize=8.5, loc="upper right", bbox_to_anchor=(1.0, 0.92))


def _draw_rates(axes: Axes, rows: Rows) -> None:
    names = list(dict.fromkeys(row["object"] for row in rows))
    for name, colour, mark in zip(names, _COLOURS, _MARKS, strict=False):
        mine = where(rows, object=name)
        how = {"color": colour, "marker": mark, "ms": 4, "label": name}
        curve(axes, mine, "times_as_fast", "error_k", (PLATE_COOLING_K_S, 1.0), **how)
    axes.axvline(PLATE_COOLING_K_S, color=GREY, linestyle=":")
    axes.axhline(0.1, color=GREY, linestyle="--", linewidth=0.9)
    log_axes(axes, (2.5, 5, 10, 20, 40, 80, 160), (0.03, 0.1, 0.3, 1))
    axes.set(xlabel="rate of the plate (K/s); dotted: TactTip", ylabel="largest error at the finger (K)")
    axes.set_title("The plate's rate is the largest error (objects at 25 °C)", loc="left")
    axes.legend(fontsize=8.5, ncols=2)


def _draw_strategies(axes: Axes, rows: Rows) -> None:
    cold = where(rows, object_c=min(each["object_c"] for each in rows))
    names = list(dict.fromkeys(row["object"] for row in cold))
    strategies = list(dict.fromkeys(row["strategy"] for row in cold))
    width = 0.8 / len(strategies)
    for number, (strategy, colour) in enumerate(zip(strategies, (GREY, BLUE, SKY, ORANGE), strict=True)):
        mine = where(cold, strategy=strategy)
        at = [place + (number - 0.5 * (len(strategies) - 1)) * width for place in range(len(names))]
        axes.bar(at, [row["error_k"] for row in mine], width, color=colour, label=strategy)
        axes.scatter(at, [row["early_k"] for row in mine], color=BLACK, marker="_", s=40, zorder=3)
    axes.set_xticks(range(len(names)), names, rotation=25, ha="right")
    axes.set_ylabel("largest error at the finger (K)")
    axes.set_title("A slow plate, objects at 25 °C; dashes: felt before contact", loc="left")
    axes.legend(fontsize=8.5)


def _draw_loop(axes: Axes, rows: Rows) -> None:
    """Draw the worst value of each tick length, relative to its allowance."""
    ticks = sorted({row["tick_s"] for row in rows})
    ticks_ms = [1e3 * tick for tick in ticks]
    for noisy, dashes in ((False, "-"), (True, "--")):
        mine = [[row for row in rows if row["tick_s"] == tick and (row["noise_k"] > 0.0) is noisy] for tick in ticks]
        for key, allowed, colour, mark, label in (
            ("share_where_rate_allows", 2.0, BLUE, "o", "error where the rate allows / 2 tolerances"),
            ("beyond_k", 0.3, RED, "s", "overshoot of the felt temperature / 0.3 K"),
            ("plate_swing_k", 0.3, GREEN, "^", "plate's swing at rest / 0.3 K"),
        ):
            worst, shown = [max(row[key] for row in each) / allowed for each in mine], None if noisy else label
            axes.plot(ticks_ms, worst, color=colour, marker=mark, ms=4, linestyle=dashes, label=shown)
    axes.axhspan(1.0, 1.2, color=PALE, zorder=0)
    log_axes(axes, ticks_ms)
    axes.set(ylim=(0.0, 1.2))
    axes.set_xlabel("length of a tick (ms); dashed: readings 0.1 K noisy and 0.1 s late")
    axes.set_ylabel("worst of all touches / allowed")
    count = len({(row["object"], row["object_c"]) for row in rows})
    axes.set_title(f"The whole loop, {count} touches", loc="left")
    axes.legend(fontsize=8.5, loc="center left", bbox_to_anchor=(0.0, 0.62))


def _draw_inverse(axes: Axes, rows: Rows) -> None:
    models = list(dict.fromkeys(row["model"] for row in rows if row["way"] == "one-step inverse"))
    for model, colour, mark in zip(models, (RED, ORANGE, PLUM, SKY), _MARKS, strict=False):
        mine = where(rows, model=model, way="one-step inverse")
        for late in (False, True):
            course = [row for row in mine if (row["delay_s"] > 0.0) is late]
            right = [row for row in course if row["plate_noise_k"] is not None]
            if not late:
                label = f"{model}, inverted"
                curve(axes, right, "step_s", "plate_noise_k", color=colour, marker=mark, ms=4, label=label)
            wrong = [row for row in course if row["plate_noise_k"] is None]
            axes.plot([row["step_s"] for row in wrong], [_BLOWN_UP_K] * len(wrong), "x", color=colour, ms=8, mew=2)
    matched = next(row for row in rows if row["way"] == "flux matching")
    axes.plot(matched["step_s"], matched["plate_noise_k"], "*", color=BLACK, ms=12, label="flux matched")
    axes.text(0.07, _BLOWN_UP_K, "beyond all bounds, readings 0.1 s late", va="center", fontsize=8.5)
    log_axes(axes, (0.01, 0.05, 0.2, 1), (0.01, 0.1, 1, 10))
    axes.set(ylim=(0.003, 2.0 * _BLOWN_UP_K), ylabel="noise of the plate's set-point (K)")
    axes.set_xlabel("step of the inverse (s)")
    axes.set_title("10 mK of noise in the wanted felt temperature", loc="left")
    axes.legend(fontsize=8.5, loc="lower left")
