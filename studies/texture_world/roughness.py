"""Compares the shipped roughness of strokes with the power of the models that made them."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from remote_site.texture.calibration.law_fit import LabelledStroke, fit_law, mean_ln_roughness
from remote_site.texture.texture_law import TextureLaw
from studies.texture_world.models import TextureModel
from studies.texture_world.strokes import own_ln_rms, stroke_over

Row = dict[str, Any]
EACH = 6
"""Number of strokes of each texture; five are labelled, and one is judged."""
LAW_EACH, LAW_TEXTURES = 2, 10
"""The law of the sensor is fitted to two other strokes of each of ten textures, evenly over all."""
RENDERED = EACH + LAW_EACH
"""Number of the stroke of each texture that is rendered; all strokes of a texture have a number of their own."""


def sensor_law(models: Sequence[TextureModel], seed: int) -> TextureLaw:
    """Fit the law of the sensor."""
    places = range(0, len(models), max(1, len(models) // LAW_TEXTURES))
    strokes = [
        LabelledStroke(
            f"stroke {number}", models[place].material, stroke_over(models[place], seed, place, EACH + number).even()
        )
        for place in places
        for number in range(LAW_EACH)
    ]
    return fit_law(strokes).law


def roughnesses(models: Sequence[TextureModel], places: Sequence[int], law: TextureLaw, seed: int) -> Iterator[Row]:
    """Yield the roughness of each stroke over some of the textures, at these places, beside the model's own rms."""
    for place in places:
        model, own = models[place], own_ln_rms(models[place])
        for number in range(EACH):
            found = mean_ln_roughness(stroke_over(model, seed, place, number).even(), law)
            yield {"material": model.material, "stroke": number, "own_ln_rms": own, "ln_roughness": found}


def ranking(rows: Sequence[Row]) -> Row:
    """Return rank correlations of roughness and own rms, and the share right by roughness alone from one stroke."""
    own = np.array([row["own_ln_rms"] for row in rows]).reshape(-1, EACH)[:, 0]
    found = np.array([row["ln_roughness"] for row in rows]).reshape(-1, EACH)
    labelled, judged = found[:, :-1].mean(axis=1), found[:, -1]
    nearest = np.abs(judged[:, None] - labelled).argmin(axis=1)
    return {
        "textures": len(own),
        "spearman_five_strokes": float(spearmanr(labelled, own)[0]),
        "spearman_one_stroke": float(spearmanr(judged, own)[0]),
        "scatter_ln": float(np.sqrt(found.var(axis=1, ddof=1).mean())),
        "spread_ln": float(labelled.std()),
        "right_by_roughness_alone": float(np.mean(nearest == np.arange(len(own)))),
    }
