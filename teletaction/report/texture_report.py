"""Describes a texture calibration: results and recognition rates, as text."""

from math import exp

from remote_site.texture.calibration.texture_calibration import TextureFit


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
