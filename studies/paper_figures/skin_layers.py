"""Reproduces the paper's Fig. 6: temperatures of the skin's layers in free motion and then on iron or wood of 35 C.

The paper does not give the skin's start temperatures. The usual start of this skin model makes a step of less than 2 K.
A finger that is colder inside makes the same shape larger.
"""

from collections.abc import Iterator
from typing import Any

from operator_site.thermal.scene_skin import SceneSkin
from operator_site.thermal.skin_model import STEP_S, SkinModel, Touched
from operator_site.thermal.tissue import Body, rest

OBJECTS = ("iron", "wood")
OBJECT_C = 35.0
AIR_C = 25.0
STARTS = {"usual": Body(air_c=AIR_C), "colder": Body(air_c=AIR_C, deep_c=31.0, arterial_c=32.0)}
"""Temperatures of the body in each case."""
FREE_S, TOUCHED_S = 2.0, 10.0
MODEL = SkinModel(20, 10, 10, 30)
SHOWN_EVERY_S = 0.05


def layer_rows() -> list[dict[str, Any]]:
    """Return the mean temperature of each layer over time, C; contact is at 0 s."""
    return [
        {"start": start, "object": name, **row}
        for start, body in STARTS.items()
        for name in OBJECTS
        for row in _rows(body, name)
    ]


def start_rows() -> list[dict[str, Any]]:
    """Return the start temperatures of each case, C."""
    rows = []
    for start, body in STARTS.items():
        at_rest = rest(body)
        layers = dict(zip(("epidermis_c", "dermis_c", "subcutis_c"), at_rest.layers_c, strict=True))
        rows.append({"start": start, "deep_c": body.deep_c, "surface_c": at_rest.surface_c, **layers})
    return rows


def _rows(body: Body, name: str) -> Iterator[dict[str, Any]]:
    skin = SceneSkin(MODEL, body, fingers=1)
    every, contact = round(SHOWN_EVERY_S / STEP_S), round(FREE_S / STEP_S)
    state = skin.state()
    for step in range(round((FREE_S + TOUCHED_S) / STEP_S) + 1):
        if step == contact:
            skin.touch(0, Touched.of(name), OBJECT_C)
        if step % every == 0:
            yield {
                "time_s": STEP_S * (step - contact),
                "epidermis_c": state.epidermis_c[0],
                "dermis_c": state.dermis_c[0],
                "subcutis_c": state.subcutis_c[0],
            }
        state = skin.step()
