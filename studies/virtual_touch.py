"""Builds the touch packets of a virtual object, as a remote site would send them for an exactly known object."""

from collections.abc import Mapping, Sequence

import numpy as np

from common.fingers import FINGERS
from common.materials import material
from common.messages import TOUCH_BLOCK, TOUCH_COLUMN, TOUCH_FIELDS, Event, ExplorationMode, Touch
from common.packets import LinkState
from teletaction.testbed.rendered_fingers import SESSION

_NO_NAMES = ("",) * len(FINGERS)


def touch_packet(sequence: int, fingers: Mapping[int, Mapping[str, float]], events: Sequence[Event] = ()) -> Touch:
    """Return a packet with these columns of these fingers; the other fingers touch nothing."""
    block = np.zeros((len(FINGERS), len(TOUCH_FIELDS)), dtype=np.float32)
    for finger, columns in fingers.items():
        for name, value in columns.items():
            block[finger, TOUCH_COLUMN[name]] = value
    sent = Touch(SESSION, sequence, 1, LinkState.ENGAGED, TOUCH_BLOCK.to_bytes(block), _NO_NAMES, tuple(events))
    return Touch.decode(sent.encode())


def resting_on(name: str, object_c: float, stiffness_n_m: float) -> dict[str, float]:
    """Return the columns of a finger that rests on a material of a temperature, C; raise KeyError if it is unknown."""
    known = material(name)
    return {
        "mode": ExplorationMode.QUIESCENT,
        "contact": 1.0,
        "stiffness_n_m": stiffness_n_m,
        "conductivity_w_mk": known.conductivity_w_mk,
        "density_kg_m3": known.density_kg_m3,
        "specific_heat_j_kgk": known.specific_heat_j_kgk,
        "object_c": object_c,
        "probability": 1.0,
    }
