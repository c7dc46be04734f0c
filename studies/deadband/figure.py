"""Figure of the study of deadbands: packets against error, errors after a loss, false gaps, and touch."""

from pathlib import Path

from matplotlib.axes import Axes

from common.link.deadband import FORCE_WEBER, HEIGHT_M
from studies.drawing import WIDEST_IN, Data, curve, draw_panels, log_axes, where
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, PALE, RED, absent

_RECKONINGS = {"hold": (RED, "o"), "linear": (BLUE, "s")}
_SHARES = (5, 10, 20, 50, 100)
_HEADROOM = 500.0
"""Upper end of an axis of shares, %; it leaves room for the legend above the lines."""
_NO_RECORDINGS = "no recordings (TELETACTION_DATA)"


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    panels = ((_draw_recorded, _draw_scripted), (_draw_touch, _draw_after_loss), (_draw_above, _draw_gaps))
    draw_panels(data, path, (WIDEST_IN, 12.5), panels)


def _draw_recorded(axes: Axes, data: Data) -> None:
    axes.set_title(f"Recorded hands ({data['recorded_seconds']:.0f} s), nothing lost", loc="left")
    _draw_sweep(axes, data, "recorded")


def _draw_scripted(axes: Axes, data: Data) -> None:
    axes.set_title("Scripted hand over the scene, nothing lost", loc="left")
    _draw_sweep(axes, data, "scripted")


def _draw_sweep(axes: Axes, data: Data, motion: str) -> None:
    rows = where(data["sweep"], motion=motion)
    if not rows:
        absent(axes, _NO_RECORDINGS)
        return
    for reckoning, (colour, mark) in _RECKONINGS.items():
        for rate_hz, line in ((1000.0, "-"), (500.0, "--")):
            mine = where(rows, reckoning=reckoning, rate_hz=rate_hz)
            label = f"{reckoning}, {rate_hz:g} Hz"
            how = {"color": colour, "marker": mark, "ms": 5, "ls": line, "label": label}
            curve(axes, mine, "largest_mm", "sent_share", (1.0, 100.0), **how)
    axes.axhspan(1.0, 15.0, color=PALE, zorder=0)
    axes.axvline(1e3 * HEIGHT_M, color=GREEN, linestyle=":", label="step of a height: 7 % of 1.4 N")
    axes.axvline(data["limit_mm"], color=BLACK, linestyle=":", label=f"limit: {data['limit_mm']:g} mm, 1 degree")
    log_axes(axes, (0.02, 0.05, 0.1, 0.2, 0.5, 1), _SHARES)
    axes.set(ylim=(5.0, _HEADROOM), xlabel="largest error (mm)", ylabel="packets sent (% of the ticks); grey: goal")
    axes.legend(loc="upper right")


def _draw_touch(axes: Axes, data: Data) -> None:
    axes.set_title("Touch: recorded forces; dots: packets of five fingers", loc="left")
    for rate_hz, line in ((1000.0, "-"), (500.0, "--")):
        mine = where(data["forces"], rate_hz=rate_hz)
        label = f"forces, {rate_hz:g} Hz"
        curve(axes, mine, "weber", "sent_share", (100.0, 100.0), color=ORANGE, marker="o", ms=5, ls=line, label=label)
    whole = next(row for row in data["touch"] if row["act"] == "all")
    seconds = whole["ticks"] / 500.0
    label = f"whole packets, 500 Hz ({seconds:.0f} s of work)"
    axes.plot([100.0 * FORCE_WEBER], [100.0 * whole["sent_share"]], color=BLUE, marker="D", linestyle="", label=label)
    axes.axvline(100.0 * FORCE_WEBER, color=BLACK, linestyle=":", label="7 %: JND of force")
    log_axes(axes, y=_SHARES)
    axes.set(ylim=(5.0, _HEADROOM), xlabel="step, share of the force (%)", ylabel="packets sent (% of the ticks)")
    axes.legend()


def _draw_after_loss(axes: Axes, data: Data) -> None:
    axes.set_title("After a lost packet, a fifth of all lost (1 kHz)", loc="left")
    if not data["after_loss"]:
        absent(axes, _NO_RECORDINGS)
        return
    for reckoning, (colour, _) in _RECKONINGS.items():
        for repeats, line in ((0, "--"), (1, "-")):
            mine = where(data["after_loss"], reckoning=reckoning, repeats=repeats)
            times = "repeated" if repeats else "sent once"
            curve(axes, mine, "after_ms", "p95_mm", color=colour, linestyle=line, label=f"{reckoning}, {times}")
    axes.axhline(data["limit_mm"], color=BLACK, linestyle=":")
    axes.axvline(data["refresh_ms"], color=GREY, linestyle=":", label="a refresh later")
    axes.set_ylim(0.0, 1.5 * data["limit_mm"])
    axes.set(xlabel="time since the loss (ms)", ylabel="error, 95 of 100 losses below (mm)")
    axes.legend()


def _draw_above(axes: Axes, data: Data) -> None:
    axes.set_title(f"Above {data['limit_mm']:g} mm while a fifth is lost, and the longest time", loc="left")
    if not data["loss"]:
        absent(axes, _NO_RECORDINGS)
        return
    rows = where(data["loss"], loss=0.20)
    for reckoning, (colour, mark) in _RECKONINGS.items():
        for rate_hz, line, aside, side in ((1000.0, "-", -6, "right"), (500.0, "--", 6, "left")):
            mine = where(rows, reckoning=reckoning, rate_hz=rate_hz)
            repeats, above = [row["repeats"] for row in mine], [100.0 * row["above_share"] for row in mine]
            label = f"{reckoning}, {rate_hz:g} Hz"
            axes.plot(repeats, above, color=colour, marker=mark, ms=5, linestyle=line, label=label)
            for at, share, row in zip(repeats, above, mine, strict=True):
                longest = f"{row['longest_above_ms']:.0f} ms"
                axes.annotate(
                    longest, (at, share), (aside, 3), textcoords="offset points", ha=side, color=colour, fontsize=8
                )
    axes.set_xticks([0, 1, 2])
    axes.set(xlim=(-0.3, 2.3), ylim=(-0.1, None), xlabel="repeats of each change", ylabel="share of the time (%)")
    axes.legend()


def _draw_gaps(axes: Axes, data: Data) -> None:
    axes.set_title("A resting hand taken for gone (gap of 100 ms)", loc="left")
    for loss, colour in ((0.20, RED), (0.10, ORANGE), (0.05, BLUE), (0.01, GREEN)):
        mine = where(data["gaps"], loss=loss)
        curve(axes, mine, "refresh_ms", "in_an_hour", color=colour, label=f"{loss:.0%} lost")
        curve(axes, mine, "refresh_ms", "drawn_in_an_hour", color=colour, marker="o", ms=4, linestyle="")
    axes.axhline(1.0, color=BLACK, linestyle=":", label="once in an hour")
    axes.axvline(data["refresh_ms"], color=GREY, linestyle=":", label="the refresh")
    log_axes(axes, y=(0.001, 0.01, 0.1, 1, 10, 100, 1000))
    axes.set(ylim=(1e-4, 1e4), xlabel="refresh (ms); dots: drawn", ylabel="times in an hour")
    axes.legend()
