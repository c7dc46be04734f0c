"""The touch block of a packet, made of what identification says of each finger."""

import struct
from collections.abc import Mapping

import numpy as np

from common.fingers import FINGERS
from common.messages import TOUCH_BLOCK, TOUCH_FIELDS, TOUCH_HIGH, TOUCH_LOW
from common.packets import BadPacket, Floats
from remote_site.finger_touch import FingerTouch
from remote_site.surface_class import GROOVE_DECAY_PER_S, GROOVE_RAD_S, TAP_DECAY_PER_S, TAP_SPEED_PER_M_S

_THERMAL_UNKNOWN_SD_K = 50.0
_EFFUSIVITY_UNKNOWN_LN_SD = _STIFFNESS_UNKNOWN_LN_SD = 10.0
_UNUSED = (0.0,) * len(TOUCH_FIELDS)
_NO_SURFACE = (0.0, _STIFFNESS_UNKNOWN_LN_SD, 0.0, 0.0, 0.0)
_NO_OBJECT = (0.0, 0.0, 0.0, _EFFUSIVITY_UNKNOWN_LN_SD, 0.0, _THERMAL_UNKNOWN_SD_K)
_FLOATS = struct.Struct(f"<{len(FINGERS) * len(TOUCH_FIELDS)}f")


def touch_block(touches: Mapping[int, FingerTouch], x_m: float, y_m: float) -> bytes:
    """The bytes of the touch block with the hand over (x, y), m.

    What an estimator says beyond the packet's ranges saturates there: a site never falls silent over it.

    Args:
        touches: of the fingers in use, by number; zeros stand for the others.
        x_m: of the hand.
        y_m: of the hand.
    """
    values: list[float] = []
    for finger in range(len(FINGERS)):
        touch = touches.get(finger)
        values += _UNUSED if touch is None else _row(touch, x_m, y_m)
    try:
        return TOUCH_BLOCK.check(_FLOATS.pack(*values))
    except (BadPacket, OverflowError):
        block: Floats = np.array(values, dtype=np.float32).reshape(len(FINGERS), -1)
        return TOUCH_BLOCK.to_bytes(np.minimum(np.maximum(block, TOUCH_LOW), TOUCH_HIGH))


def _row(touch: FingerTouch, x_m: float, y_m: float) -> tuple[float, ...]:
    """One finger's line of the touch block, in the order of `TOUCH_FIELDS`, with the hand over (x, y)."""
    # A finger that has left the object has no surface: none is rendered where nothing may be.
    surface = _NO_SURFACE
    if touch.contact:
        surface = (touch.stiffness_n_m, touch.stiffness_ln_sd, touch.damping_n_s_m, touch.slope_x, touch.slope_y)
    return (
        touch.mode,
        touch.contact,
        touch.contact_force_n,
        x_m,
        y_m,
        touch.surface_z_m,
        *surface,
        TAP_SPEED_PER_M_S,
        TAP_DECAY_PER_S,
        touch.k_stroke_v,
        touch.k_stroke_f,
        GROOVE_RAD_S,
        GROOVE_DECAY_PER_S,
        *_heat(touch),
    )


def _heat(touch: FingerTouch) -> tuple[float, ...]:
    """The last columns of a finger's line: what the object is made of, and how warm it is."""
    thermal = touch.thermal
    if thermal.object_c is None:
        return (*_NO_OBJECT, thermal.probability, thermal.status)
    effusivity_ln_sd = thermal.effusivity_ln_sd if touch.conductivity_w_mk > 0.0 else None
    return (
        touch.conductivity_w_mk,
        touch.density_kg_m3,
        touch.specific_heat_j_kgk,
        _EFFUSIVITY_UNKNOWN_LN_SD if effusivity_ln_sd is None else effusivity_ln_sd,
        thermal.object_c,
        thermal.object_c_sd or 0.0,
        thermal.probability,
        thermal.status,
    )
