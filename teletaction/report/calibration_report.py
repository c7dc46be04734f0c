"""Describes a calibration: results, recognition rates and quality of fit, as text, and as a figure for thermal ones."""

from math import exp

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from remote_site.texture.calibration.spectrum_calibration import SpectrumFit
from remote_site.texture.calibration.texture_calibration import TextureFit
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


def texture_text(fit: TextureFit) -> str:
    """Return the sensor's law, one line for each surface with its confusions, and warnings."""
    table, law = fit.table, fit.table.law
    usual = " (usual, not fitted)"
    lines = [
        f"sensor {table.sensor_serial}, {table.made_on or 'no date'}",
        f"curvature = roughness * force^{law.force_exponent:.2f}{'' if fit.law.force_known else usual} "
        f"* speed^{law.speed_exponent:+.2f}{'' if fit.law.speed_known else usual}",
        f"viscosity {1e3 * law.viscous_s:.2f} ms{'' if fit.law.speed_known else usual}, "
        f"noise {1e3 * law.noise_v:.1f} mV{'' if fit.law.noise_known else usual}, "
        f"left within surfaces {100.0 * fit.law.left_ln:.0f} %",
        "",
        f"{'surface':<26}{'strokes':>8}{'roughness mV':>14}{'+- %':>6}{'grooves mm':>12}{'recognised':>12}",
    ]
    for surface in table.surfaces:
        taken = fit.taken_for[surface.name]
        grooves = "-" if surface.period_mm is None else f"{surface.period_mm:.2f}"
        lines.append(
            f"{surface.name:<26}{fit.strokes[surface.name]:>8}{1e3 * exp(surface.ln_roughness):>14.2f}"
            f"{100.0 * fit.scatter[surface.name]:>6.0f}{grooves:>12}"
            f"{f'{taken.get(surface.name, 0)}/{sum(taken.values())}':>12}"
        )
        lines += [f"    {times} taken for {other}" for other, times in sorted(taken.items()) if other != surface.name]
    if table.spectra is not None:
        lines.append("recorded strokes: surfaces by their spectra; live strokes: by roughness and grooves")
    if (scale := table.roughness_scale) is not None:
        lines.append(
            f"roughness in um: {exp(scale.ln_um):.3g} * (roughness in V)^{scale.exponent:.2f} +- "
            f"{100.0 * scale.ln_sd:.0f} %, {1e3 * scale.least_v:.2f} to {1e3 * scale.most_v:.2f} mV, "
            f"{fit.scaled} strokes"
        )
    return "\n".join([*lines, *(f"warning: {warning}" for warning in fit.warnings)])


ALONG = {"m": "mm", "s": "s", "stroke": "strokes"}
"""Printed unit of wavelength for each axis of a model."""


def spectrum_text(fit: SpectrumFit) -> str:
    """Return wavelength bands, misfits and the confusion table of the strokes left out.

    Rows are true surfaces, columns identified ones.
    """
    table = fit.table
    lines = [f"sensor {table.sensor_serial}, {table.made_on or 'no date'}; {table.signals} signals"]
    for model in table.models:
        scale = 1e3 if model.along == "m" else 1.0
        lines.append(
            f"wavelengths {scale / model.edges[-1]:.3g} to {scale / model.edges[0]:.3g} {ALONG[model.along]} "
            f"in {len(model.edges) - 1} bands, misfit {model.misfit:.2f}"
        )
    if not fit.left_out:
        return "\n".join(
            [*lines, "warning: no stroke could be left out: the recognition rate of these surfaces is not known"]
        )
    right = sum(label == said for label, said in fit.left_out)
    what = "all strokes of its load (or itself, of a surface with one load)" if fit.by_load else "itself"
    lines += [
        "",
        f"each stroke identified by a table made without {what}: {right} of {len(fit.left_out)} right",
        f"{'is':<16}" + "".join(f"{shown_name(name, 11):>12}" for name in table.surfaces),
    ]
    for label in table.surfaces:
        said = [answer for truth, answer in fit.left_out if truth == label]
        lines.append(f"{shown_name(label, 15):<16}" + "".join(f"{said.count(name):>12}" for name in table.surfaces))
    if not fit.by_load:
        lines.append("warning: no surface has two loads: the effect of another pressure is not known")
    if fit.without_speed:
        lines.append(
            f"warning: {fit.without_speed[0]}: no speed_mm_s (number of such strokes: {len(fit.without_speed)}), so "
            "that no speed is used, and all strokes are assumed to be made alike; add the column to labels.csv"
        )
    return "\n".join(lines)
