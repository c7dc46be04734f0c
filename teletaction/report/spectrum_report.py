"""Describes a calibration from slow strokes: results and cross-validation, as text."""

from remote_site.texture.calibration.spectrum_calibration import SpectrumFit
from teletaction.plotting.figure_style import shown_name

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
    if len(table.models) < 2:
        lines.append(
            "speeds are not known: all strokes are assumed to be made in the same way (labels.csv: speed_mm_s)"
        )
    return "\n".join(lines)
