"""The touch block of a packet, made of what identification says of each finger."""

from collections.abc import Mapping

import numpy as np

from common.fingers import FINGERS
from common.wire.messages import (
    NO_TOUCH,
    TOUCH_BLOCK,
    TOUCH_HIGH,
    TOUCH_LOW,
    ThermalReason,
    TouchRow,
    explains,
    pack_rows,
)
from common.wire.packets import BadPacket, Floats
from remote_site.identification.finger_touch import FingerTouch
from remote_site.texture.surface_table import GROOVE_DECAY_PER_S, GROOVE_RAD_S, TAP_DECAY_PER_S, TAP_SPEED_PER_M_S

_THERMAL_UNKNOWN_SD_K = 50.0
_EFFUSIVITY_UNKNOWN_LN_SD = _STIFFNESS_UNKNOWN_LN_SD = 10.0


def touch_block(touches: Mapping[int, FingerTouch], x_m: float, y_m: float) -> bytes:
    """The bytes of the touch block with the hand over (x, y), m.

    What an estimator says beyond the packet's ranges saturates there: a site never falls silent over it.

    Args:
        touches: of the fingers in use, by number; zeros stand for the others.
        x_m: of the hand.
        y_m: of the hand.
    """
    rows = [_row(touches[finger], x_m, y_m) if finger in touches else NO_TOUCH for finger in range(len(FINGERS))]
    try:
        return TOUCH_BLOCK.check(pack_rows(rows))
    except (BadPacket, OverflowError):
        block: Floats = np.array(rows, dtype=np.float32)
        return TOUCH_BLOCK.to_bytes(np.minimum(np.maximum(block, TOUCH_LOW), TOUCH_HIGH))


def _row(touch: FingerTouch, x_m: float, y_m: float) -> TouchRow:
    """One finger's row with the hand over (x, y)."""
    # A finger that has left the object has no surface: none is rendered where nothing may be.
    contact, thermal = touch.contact, touch.thermal
    known = thermal.object_c is not None
    effusivity_ln_sd = thermal.effusivity_ln_sd if known and touch.conductivity_w_mk > 0.0 else None
    return TouchRow(
        mode=touch.mode,
        contact=contact,
        contact_force_n=touch.contact_force_n,
        x_m=x_m,
        y_m=y_m,
        surface_z_m=touch.surface_z_m,
        stiffness_n_m=touch.stiffness_n_m if contact else 0.0,
        stiffness_ln_sd=touch.stiffness_ln_sd if contact else _STIFFNESS_UNKNOWN_LN_SD,
        damping_n_s_m=touch.damping_n_s_m if contact else 0.0,
        slope_x=touch.slope_x if contact else 0.0,
        slope_y=touch.slope_y if contact else 0.0,
        k_tap=TAP_SPEED_PER_M_S,
        b_tap_per_s=TAP_DECAY_PER_S,
        k_stroke_v=touch.k_stroke_v,
        k_stroke_f=touch.k_stroke_f,
        groove_rad_s=GROOVE_RAD_S,
        b_groove_per_s=GROOVE_DECAY_PER_S,
        conductivity_w_mk=touch.conductivity_w_mk if known else 0.0,
        density_kg_m3=touch.density_kg_m3 if known else 0.0,
        specific_heat_j_kgk=touch.specific_heat_j_kgk if known else 0.0,
        effusivity_ln_sd=_EFFUSIVITY_UNKNOWN_LN_SD if effusivity_ln_sd is None else effusivity_ln_sd,
        object_c=0.0 if thermal.object_c is None else thermal.object_c,
        object_c_sd=(thermal.object_c_sd or 0.0) if known else _THERMAL_UNKNOWN_SD_K,
        probability=thermal.probability,
        thermal_status=thermal.status,
        thermal_reason=thermal.reason if explains(thermal.reason, thermal.status) else ThermalReason.NONE,
    )
