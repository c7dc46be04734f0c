"""A bare fingertip on a real object: the simulators' finger joined to a fine column of the object."""

import numpy as np

from common.scenes.materials import material
from operator_site.thermal.skin_model import contact_resistance_m2k_w
from sim_sensors.physics.finger_plate import DEEP_C
from sim_sensors.physics.object_column import object_column
from studies.touches.simulated_finger import STEP_S, Array, SimulatedFinger, chain, exact_step


def real_touch(
    name: str, object_c: float, seconds: float, *, deep_c: float = DEEP_C, contact_m2k_w: float | None = None
) -> Array:
    """Change of the felt temperature every STEP_S from contact on, K: a finger from room air on a half space.

    Args:
        name: material or alias.
        object_c: temperature of the object, C.
        seconds: duration of the touch.
        deep_c: temperature of the finger's deep tissue, C.
        contact_m2k_w: contact resistance; None for that of a bare finger on this material.

    Raises:
        KeyError: no such material.
    """
    finger, touched = SimulatedFinger.with_deep_tissue_at(deep_c), material(name)
    conductivity = touched.conductivity_w_mk
    heat = touched.density_kg_m3 * touched.specific_heat_j_kgk
    size = object_column(conductivity, heat, None, STEP_S).cell_m
    half = size / (2.0 * conductivity)
    contact = contact_resistance_m2k_w(conductivity) if contact_m2k_w is None else contact_m2k_w
    between = 1.0 / (float(half[0]) + contact + finger.half_m2k_w)
    n, skin = len(size), slice(len(size), None)
    balance = np.zeros((n + len(finger.heat_j_m2k),) * 2)
    balance[:n, :n] = chain(1.0 / (half[:-1] + half[1:]))
    balance[skin, skin] = finger.balance_w_m2k
    # The first cell of the object is its surface, which meets that of the skin.
    balance[0, 0] -= between
    balance[n, n] -= between
    balance[0, n] = balance[n, 0] = between
    known = np.concatenate((np.zeros(n), finger.known_w_m2))[:, None]
    advance, drift = exact_step(balance, np.concatenate((size * heat, finger.heat_j_m2k)), known)
    now = np.concatenate((np.full(n, object_c), finger.in_air_c()))
    felt = [finger.felt_c(now[skin])]
    for _ in range(round(seconds / STEP_S)):
        now = advance @ now + drift[:, 0]
        felt.append(finger.felt_c(now[skin]))
    return np.array(felt) - felt[0]
