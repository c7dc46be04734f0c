"""Figure of the study of the link: cost above, failure region in the middle, age and safe states below."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from benchmarks.link.age import AGES_S, EVERY_TICK, ONE_CONNECTION, SHIPPED
from benchmarks.link.latency import BUSY_CURVE, CURVE, LINK, TCP, WITH_ENCODING
from benchmarks.link.load import CURVE as CURVE_LOAD
from benchmarks.link.load import LINK as LINK_LOAD
from benchmarks.link.load import LOOP
from common.limits import GAP_S
from studies.drawing import Data, Rows, curve, figure_file, keys_below, log_axes, share_map, where
from teletaction.plotting.figure_style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PALE,
    PLUM,
    RED,
    SKY,
    absent,
)

_WAY_STYLE = {
    LINK: (BLUE, "-"),
    WITH_ENCODING: (SKY, "--"),
    BUSY_CURVE: (PLUM, (0, (4, 1, 1, 1, 1, 1))),
    CURVE: (ORANGE, "-."),
    TCP: (GREY, ":"),
}
_SHARES = (0.0, 1e-9, 0.001, 0.01, 0.1, 0.5, 1.01)
_SHARE_COLOURS = ("#FFFFFF", PALE, "#F9DDB1", ORANGE, RED, "#7A1E00")
_SHARE_NAMES = ("never", "< 0.1 %", "0.1-1 %", "1-10 %", "10-50 %", "> 50 %")
_PERCENT = 100.0
_JITTERS_SHOWN = 2


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    with figure_file(path, 11.5, 11.0) as figure:
        parts = figure.subfigures(3, 1, height_ratios=(3.5, 3.3, 3.6), squeeze=False)
        cost, failure, below = parts[:, 0]
        latency, load, rate, fingers, observers = cost.subplots(1, 5, width_ratios=(2.2, 1.5, 1.1, 1.1, 1.1))
        _draw_latency(latency, data["latency"])
        _draw_load(load, data["cpu"])
        _draw_scaling(rate, data["scaling"], "rate", "touch_hz", "rate both ways (Hz)")
        _draw_scaling(fingers, data["scaling"], "fingers", "touching", "fingers touching")
        _draw_scaling(observers, data["scaling"], "observers", "observers", "observers")
        rate.set_ylabel("processor share (%)")
        rate.legend(loc="upper left", bbox_to_anchor=(-0.1, -0.2), fontsize=8.5)
        _draw_failures(failure, data["age"])
        age, safe = below.subplots(1, 2, width_ratios=(1.0, 1.1))
        _draw_age(age, data["age"])
        _draw_safe_states(safe, data["safe_states"])


def _draw_latency(axes: Axes, latency: Mapping[str, Any]) -> None:
    for row in latency["ways"]:
        colour, dash = _WAY_STYLE[row["way"]]
        label = f"{row['way']}: {row['median_us']:.0f} µs"
        axes.plot(latency["one_way_us"][row["way"]], latency["quantiles"], color=colour, linestyle=dash, label=label)
    log_axes(axes, (10, 20, 50, 100, 200, 500, 1000, 3000))
    axes.set(xlim=(8.0, 3000.0), ylim=(0.0, 1.0), xlabel="one way (µs)", ylabel="share of messages")
    axes.set_title(f"{latency['message_bytes']} bytes at {latency['rate_hz']:.0f} Hz, with medians", loc="left")
    keys_below(axes, 1, fontsize=8.5)


def _draw_load(axes: Axes, cpu: Mapping[str, Any]) -> None:
    ways = (LOOP, CURVE_LOAD, LINK_LOAD)
    for place, way in enumerate(ways):
        rows = where(cpu["measurements"], way=way)
        remote, operator = (
            _PERCENT * float(np.median([row[f"{end}_cpu"] for row in rows])) for end in ("remote", "operator")
        )
        axes.bar(place, remote, color=BLUE, width=0.6, label="remote end")
        axes.bar(place, operator, bottom=remote, color=ORANGE, width=0.6, hatch="//", label="operator end")
        axes.plot([place] * len(rows), [_PERCENT * row["all_cpu"] for row in rows], "k.", markersize=4)
    axes.set_xticks(range(len(ways)), [way.replace(" ", "\n", 1) for way in ways])
    axes.grid(axis="x", visible=False)
    axes.set_ylabel("processor share (%)")
    axes.set_title(f"link / bare: {cpu['link_to_bare']:.2f}", loc="left")
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles[:2], labels[:2], loc="upper left", bbox_to_anchor=(-0.1, -0.2), fontsize=8.5)


def _draw_scaling(axes: Axes, scaling: Rows, varied: str, name: str, label: str) -> None:
    rows = where(scaling, varied=varied)
    for column, words, how in (
        ("all_cpu", "everything", {"marker": "o", "color": BLACK}),
        ("remote_cpu", "remote end", {"marker": "s", "linestyle": "--", "color": BLUE}),
    ):
        curve(axes, rows, name, column, (1.0, _PERCENT), markersize=3.5, label=words, **how)
    axes.set(xlabel=label, ylim=(0.0, 1.1 * max((_PERCENT * row["all_cpu"] for row in scaling), default=1.0)))
    axes.set(xlim=(0.0, None))


def _draw_failures(figure: Any, age: Rows) -> None:
    """Maps of networks as shipped, with more jitter, with one connection for touch, and without a deadband."""
    jitters = sorted({row["jitter_ms"] for row in age})
    none, more = jitters[0], jitters[-1] if len(jitters) <= _JITTERS_SHOWN else jitters[len(jitters) // 2]
    limit_ms = round(AGES_S[0] * 1e3)
    figure.suptitle(
        f"Where it fails: share of time in the safe state (no packet accepted for {GAP_S * 1e3:.0f} ms), "
        f"simulated, age limit {limit_ms} ms",
        fontsize=10,
    )
    places = figure.subplots(1, 4, sharey=True)
    columns = [(none, SHIPPED), (more, SHIPPED), (none, ONE_CONNECTION), (none, EVERY_TICK)]
    for axes, (jitter, sent) in zip(places, columns, strict=True):
        rows = where(age, max_age_ms=limit_ms, jitter_ms=jitter, sent=sent)
        share_map(axes, rows, ("delay_ms", "loss_percent", "safe_state_share"), _SHARES, _SHARE_COLOURS, "#D0D0D0")
        axes.tick_params(axis="x", labelrotation=90)
        axes.set_title(f"{sent},\njitter ±{jitter} ms", loc="left")
        axes.set_xlabel("one-way delay (ms)")
    places[0].set_ylabel("loss of TCP segments (%)")
    keys = [
        Patch(facecolor=colour, edgecolor=GREY, label=name)
        for colour, name in zip(_SHARE_COLOURS, _SHARE_NAMES, strict=True)
    ]
    figure.legend(handles=keys, loc="outside lower center", ncols=len(keys))


def _draw_age(axes: Axes, age: Rows) -> None:
    age = where(age, sent=SHIPPED)
    jitters = sorted({row["jitter_ms"] for row in age})
    for limit_s, colour in zip(AGES_S, (BLUE, PLUM), strict=True):
        limit_ms = round(limit_s * 1e3)
        for jitter, dash in ((jitters[0], "-"), (jitters[-1], "--")):
            rows = [
                row
                for row in age
                if row["max_age_ms"] == limit_ms
                and row["jitter_ms"] == jitter
                and not row["loss_percent"]
                and row["age_median_ms"] is not None
            ]
            label = f"limit {limit_ms} ms, jitter ±{jitter} ms"
            curve(axes, rows, "delay_ms", "age_p99_ms", color=colour, linestyle=dash, marker="o", ms=3, label=label)
        axes.axvline(limit_ms, color=colour, linewidth=0.7, linestyle=":")
    lost = [row for row in age if row["max_age_ms"] == round(AGES_S[-1] * 1e3) and not row["jitter_ms"]]
    for percent, marker, colour in ((1.0, "^", GREEN), (10.0, "v", ORANGE)):
        rows = [row for row in lost if row["loss_percent"] == percent and row["age_p99_ms"] is not None]
        label = f"loss {percent:g} %, limit {round(AGES_S[-1] * 1e3)} ms"
        curve(axes, rows, "delay_ms", "age_p99_ms", color=colour, marker=marker, ms=4, linestyle="-.", label=label)
    axes.set(xlabel="one-way delay (ms)", ylabel="99 % of age (ms)")
    axes.set_title("age at every tick; beyond the limit nothing is accepted", loc="left")
    log_axes(axes, y=(1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000))
    keys_below(axes, 2, fontsize=8.5)


def _draw_safe_states(axes: Axes, safe: Mapping[str, Any]) -> None:
    axes.set_title("from a fault to the safe state; bars: what is allowed", loc="left")
    if not safe["faults"]:
        axes.set_axis_off()
        absent(axes, safe["note"] or "no fault made an actuator safe")
        return
    for place, (actuator, limit_s) in enumerate(safe["limits_s"].items()):
        times_ms = [1e3 * fault["safe_s"][actuator] for fault in safe["faults"] if actuator in fault["safe_s"]]
        axes.barh(place, 1e3 * limit_s, color=PALE, height=0.7)
        spread = np.linspace(-0.25, 0.25, len(times_ms)) if len(times_ms) > 1 else np.zeros(len(times_ms))
        late = np.array(times_ms) > 1e3 * limit_s + 1e-6
        axes.scatter(times_ms, place + spread, s=14, c=np.where(late, RED, BLUE), zorder=3)
    axes.set_yticks(range(len(safe["limits_s"])), list(safe["limits_s"]))
    axes.invert_yaxis()
    axes.set_xlabel(f"time (ms), {len(safe['faults'])} faults")
