"""Describes a thermal calibration: results and quality of fit, as text and a figure."""

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from remote_site.thermal.calibration.thermal_calibration import ThermalFit
from remote_site.thermal.material_table import MaterialTable
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, SKY, STYLE, shown_name
from teletaction.report.accuracy_text import accuracy_lines

COLOURS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY, BLACK)
MARKERS = "osD^vPX"
SMOOTHED = 12
"""Number of successive residuals that one drawn point averages."""


def calibration_text(fit: ThermalFit) -> str:
    """Return the sensor's constants, one line for each material, the accuracy to expect, and warnings."""
    table = fit.table
    lines = [
        f"sensor {table.sensor_serial}, {table.made_on or 'no date'}",
        f"lag {np.exp(table.ln_lag):.2f} s (factor {np.exp(table.ln_lag_sd):.2f} from touch to touch), "
        f"leak {table.leak_per_s:.3f} 1/s, half of the contact at {table.half_force_n:.2f} N "
        f"(power {table.force_power:.1f} of the force), heat {1e3 * table.early_s:+.0f} ms before force, "
        f"noise {1e3 * table.noise_k:.0f} mK",
        "",
        f"{'material':<16}{'touches':>8}{'effusivity':>12}{'+- %':>6}{'contact W/m2K':>15}{'+- %':>6}{'misfit':>8}",
    ]
    for entry in table.materials:
        (ee, _), (_, cc) = entry.covariance
        lines.append(
            f"{entry.name:<16}{entry.touches:>8}{table.effusivity(entry.ln_effusivity):>12.0f}"
            f"{100 * np.sqrt(ee):>6.0f}{np.exp(entry.ln_conductance) * table.plate_j_m2k:>15.0f}"
            f"{100 * np.sqrt(cc):>6.0f}{entry.misfit:>8.2f}"
        )
    return "\n".join([*lines, "", *accuracy_lines(fit), *(f"warning: {warning}" for warning in fit.warnings)])


def calibration_figure(fit: ThermalFit) -> Figure:
    """Draw the materials by effusivity and contact conductance, and the residuals of the fit."""
    with rc_context(STYLE):
        figure = Figure(figsize=(9.6, 4.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        _draw_materials(left, fit.table)
        noise_mk = 1e3 * fit.table.noise_k
        names = np.array(fit.names)
        for number, entry in enumerate(fit.table.materials):
            square = np.mean(fit.residual_k[names == entry.name] ** 2, axis=0)
            ends = np.arange(0, len(square) - SMOOTHED, SMOOTHED)
            rms_mk = 1e3 * np.sqrt([square[k : k + SMOOTHED].mean() for k in ends])
            right.plot(
                [fit.times_s[k : k + SMOOTHED].mean() for k in ends],
                rms_mk,
                color=COLOURS[number % 7],
                label=shown_name(entry.name),
            )
        right.axhline(noise_mk, color=BLACK, linestyle=":", label="noise assumed for one reading")
        right.set(xlabel="s since contact", ylabel="left of the readings, rms (mK)", title="Fit of all touches")
        right.set_xscale("log")
        right.set_ylim(bottom=0.0)
        right.legend(fontsize=8)
    return figure


def _draw_materials(axes: Axes, table: MaterialTable) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    circle = np.stack((np.cos(angle), np.sin(angle)))
    for number, entry in enumerate(table.materials):
        colour = COLOURS[number % 7]
        ring = np.linalg.cholesky(np.array(entry.covariance)) @ circle
        at = np.exp(np.array([[entry.ln_effusivity], [entry.ln_conductance]])) * table.plate_j_m2k
        axes.plot(*(at * np.exp(ring)), color=colour)
        axes.plot(*at, color=colour, marker=MARKERS[number % 7], linestyle="none", label=shown_name(entry.name))
    axes.set(
        xscale="log",
        xlabel="effusivity, J/(m² K √s)",
        ylabel="contact at large force, W/(m² K)",
        title="Materials, with one standard deviation",
    )
    axes.legend(fontsize=8)
