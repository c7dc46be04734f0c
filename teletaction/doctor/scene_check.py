"""Which skin model each object of a scene needs, how wrong it will be, and what it costs."""

from dataclasses import dataclass

import numpy as np

from common.fingers import FINGERS
from common.scenes.scene import Scene
from operator_site.thermal.model_error import FINE, TIMES_S, felt_per_k
from operator_site.thermal.model_selection import LONGEST_S, TOLERANCE_K, TOLERANCE_SHARE, choose
from operator_site.thermal.scene_skin import SceneSkin, touched_object
from operator_site.thermal.skin_model import SkinModel, Touched
from operator_site.thermal.tissue import Body, rest
from teletaction.session.step_cost import quickest_s

STEPS = 200
"""Timed together."""


@dataclass(frozen=True, slots=True)
class CheckedObject:
    """One object of a scene, in the order of the columns that are printed.

    Attributes:
        name: of the object.
        material: what it is of.
        object_c: its temperature that differs most from the skin's, C.
        difference_k: that difference.
        dwell_s: how long it is touched, s.
        model: what the runtime chooses.
        states: of the model.
        error_k: largest error of the felt temperature while touched, K, against a model of 100 cells.
        share: of the tolerance, at its worst moment.
        step_us: what a step of five fingers with this model takes here, us.
        why: why this model.
    """

    name: str
    material: str
    object_c: float
    difference_k: float
    dwell_s: float
    model: SkinModel
    states: int
    error_k: float
    share: float
    step_us: float
    why: str


COLUMNS = ("object", *CheckedObject.__slots__[1:])


def check_scene(scene: Scene, dwell_s: float = LONGEST_S) -> list[CheckedObject]:
    """Every object of a scene, touched for `dwell_s` (s)."""
    skin_c = rest(Body(air_c=scene.ambient_c)).surface_c
    within = dwell_s + 1e-9 >= TIMES_S
    costs: dict[SkinModel, float] = {}
    checked = []
    for thing in scene.objects:
        low_c, high_c = (
            (thing.absolute_c,) * 2
            if thing.absolute_c is not None
            else tuple(scene.ambient_c + offset for offset in thing.offset_c)
        )
        object_c = low_c if abs(low_c - skin_c) >= abs(high_c - skin_c) else high_c
        kind = scene.material(thing.material)
        touched = touched_object(kind.conductivity_w_mk, kind.density_kg_m3, kind.specific_heat_j_kgk)
        if touched is None:
            raise ValueError(f"{thing.name}: constants of {kind.name} are out of range: no finger can be shown them")
        difference_k = object_c - skin_c
        choice = choose(touched, difference_k, dwell_s)
        true = difference_k * felt_per_k(FINE, touched, TIMES_S)[within]
        error = np.abs(difference_k * felt_per_k(choice.model, touched, TIMES_S)[within] - true)
        tolerance = np.maximum(TOLERANCE_K, TOLERANCE_SHARE * np.abs(true))
        if choice.model not in costs:
            costs[choice.model] = _step_us(choice.model, touched)
        checked.append(
            CheckedObject(
                thing.name,
                kind.name,
                object_c,
                difference_k,
                dwell_s,
                choice.model,
                choice.model.states,
                float(error.max()),
                float((error / tolerance).max()),
                costs[choice.model],
                choice.why,
            )
        )
    return checked


def _step_us(model: SkinModel, touched: Touched) -> float:
    """Time of one step of a hand, us."""
    skin = SceneSkin(model)
    for finger in range(len(FINGERS)):
        skin.touch(finger, touched, 20.0)
    return 1e6 * quickest_s(skin.step, STEPS)
