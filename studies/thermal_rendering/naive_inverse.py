"""Shows why the second skin model is not inverted: one step's exact solution amplifies small noise and delays.

The naive way solves one step of the finger on the plate. It finds the plate temperature that makes the felt temperature
right at the step's end. Its finger model is driven by the plate's readings. Flux matching needs neither a step nor a
reading: it sets the plate to the temperature at which the scene's flux crosses the contact.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from operator_site.thermal.plates import PLATE_CONTACT_M2K_W
from operator_site.thermal.scene_skin import SceneSkin
from operator_site.thermal.skin_model import STEP_S, SkinModel, SkinStep, Touched, skin_step
from operator_site.thermal.tissue import Body

MODELS = (SkinModel(1, 1, 1), SkinModel(2, 1, 1), SkinModel(4, 1, 1), SkinModel(10, 10, 10))
STEPS_S = (0.01, 0.05, 0.2, 1.0)
NOISE_K = 0.01
"""Noise of the wanted felt temperature, K: a tenth of what can be felt."""
DELAYS_S = (0.0, 0.1)
SECONDS = 10.0
BEYOND_K = 1e4
_PLATE = Touched(1.0, 1.0, 1.0, PLATE_CONTACT_M2K_W)


def inverse_rows(seed: int) -> Iterator[dict[str, Any]]:
    """Noise of the plate's set-point for NOISE_K in the wanted felt temperature; None where it grows without bound."""
    for model in MODELS:
        for step_s in STEPS_S:
            step = skin_step(model, _PLATE, Body().air_w_m2k, step_s)
            for delay_s in DELAYS_S:
                yield {
                    "way": "one-step inverse",
                    "model": str(model),
                    "step_s": step_s,
                    "delay_s": delay_s,
                    "plate_k_per_felt_k": 1.0 / float(step.c[0] @ step.b[:, 1]),
                    "plate_noise_k": _noise_k(step, round(SECONDS / step_s), round(delay_s / step_s), seed),
                }
    matched_k = _matched_noise_k(seed)
    for delay_s in DELAYS_S:  # flux matching does not read the plate
        yield {
            "way": "flux matching",
            "model": "4+1+1+6",
            "step_s": STEP_S,
            "delay_s": delay_s,
            "plate_k_per_felt_k": None,
            "plate_noise_k": matched_k,
        }


def _noise_k(step: SkinStep, steps: int, late: int, seed: int) -> float | None:
    """Standard deviation of the set-point for a finger that should feel only noise, K; readings lag by `late` steps."""
    random, x, plate_k = np.random.default_rng(seed), np.zeros(len(step.a)), [0.0] * late
    gain = float(step.c[0] @ step.b[:, 1])
    for wanted_k in NOISE_K * random.standard_normal(steps):
        plate_k.append((wanted_k - float(step.c[0] @ (step.a @ x))) / gain)
        if abs(plate_k[-1]) > BEYOND_K:
            return None
        x = step.a @ x + step.b[:, 1] * plate_k[-1 - late]
    return float(np.std(plate_k[late:]))


def _matched_noise_k(seed: int) -> float:
    """The same for flux matching on copper, the object with the largest flux; its temperature has the noise."""
    random, copper = np.random.default_rng(seed), Touched.of("copper")
    quiet, noisy = (SceneSkin(SkinModel(4, 1, 1, 6), fingers=1) for _ in range(2))
    object_c = 25.0
    quiet.touch(0, copper, object_c)
    difference = []
    for noise_k in NOISE_K * random.standard_normal(round(SECONDS / STEP_S)):
        noisy.touch(0, copper, object_c + noise_k)
        difference.append(_set_point(noisy) - _set_point(quiet))
    return float(np.std(difference))


def _set_point(skin: SceneSkin) -> float:
    state = skin.step()
    return state.surface_c[0] + state.flux_w_m2[0] * PLATE_CONTACT_M2K_W
