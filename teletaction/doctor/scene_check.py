"""Finds the skin model that each object of a scene needs, with its predicted error and computing cost."""

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
"""Number of model steps in one timing round."""


@dataclass(frozen=True, slots=True)
class CheckedObject:
    """One object of a scene. The attributes are in the order of the printed columns.

    Attributes:
        name: name of the object.
        material: material of the object.
        object_c: the temperature in the object's range that differs most from the skin's, C.
        difference_k: `object_c` minus the skin's temperature at rest, K.
        dwell_s: contact time, s.
        model: the model that the runtime chooses.
        states: number of states of the model.
        error_k: largest error of the felt temperature during contact, K, against a model of 100 cells.
        share: largest ratio of the error to its tolerance during contact.
        step_us: time of one step of five fingers with this model on this machine, us.
        why: reason for the choice of this model.
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
    """Check every object of a scene in a contact of `dwell_s` (s).

    Raises:
        ValueError: the constants of a material are out of the displayable range.
    """
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
            raise ValueError(f"{thing.name}: constants of {kind.name} are out of range: they cannot be displayed")
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
    """Return the time of one step of the models of all fingers, us."""
    skin = SceneSkin(model)
    for finger in range(len(FINGERS)):
        skin.touch(finger, touched, 20.0)
    return 1e6 * quickest_s(skin.step, STEPS)
