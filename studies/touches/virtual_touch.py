"""Builds the touch packets of a virtual object, as a remote site would send them for an exactly known object."""

from collections.abc import Mapping, Sequence

from common.fingers import FINGERS
from common.scenes.materials import material
from common.wire.messages import NO_TOUCH, Event, ExplorationMode, Touch, pack_rows
from common.wire.packets import LinkState
from teletaction.testbed.rendered_fingers import SESSION

_NO_NAMES = ("",) * len(FINGERS)


def touch_packet(sequence: int, fingers: Mapping[int, Mapping[str, float]], events: Sequence[Event] = ()) -> Touch:
    """Return a packet with these columns of these fingers; the other fingers touch nothing."""
    rows = [NO_TOUCH._replace(**fingers.get(finger, {})) for finger in range(len(FINGERS))]
    sent = Touch(SESSION, sequence, 1, LinkState.ENGAGED, pack_rows(rows), _NO_NAMES, tuple(events))
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
