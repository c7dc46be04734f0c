"""The simulators' finger on an ideal plate that is always at its set-point, within its rate limit.

The plate follows the flux of the operator site's scene model, as a TactTip's does. Peltiers, controller, sensor and
gate are left out. The result thus shows what a plate of any rate could do.
"""

from dataclasses import replace

import numpy as np

from common.limits import COMFORT, PLATE_COOLING_K_S, PLATE_HEATING_K_S
from operator_site.thermal.contact_prediction import contact_c
from operator_site.thermal.plates import PLATE_CONTACT_M2K_W
from operator_site.thermal.scene_skin import SceneSkin
from operator_site.thermal.skin_model import STEP_S, Touched
from operator_site.thermal.tissue import Body
from sim_sensors.physics.finger_plate import DEEP_C, PLATE_FINGER_M2K_W
from studies.touches.simulated_finger import Array, SimulatedFinger, exact_step


def ideal_plate_touch(
    name: str,
    object_c: float,
    seconds: float,
    *,
    faster: float = 1.0,
    share: float = 1.0,
    lead_s: float = 0.0,
    deep_c: float = DEEP_C,
    contact_m2k_w: float | None = None,
) -> Array:
    """Change of the felt temperature every STEP_S from contact on, K, against a finger at rest on the neutral plate.

    Args:
        name: material or alias of the object that is rendered.
        object_c: its temperature, C.
        seconds: duration of the touch.
        faster: rates of heating and cooling, as a multiple of a TactTip's.
        share: share of the plate's way from the neutral temperature that is displayed.
        lead_s: time before contact at which the plate starts for the temperature where finger and object will meet, s.
        deep_c: temperature of deep tissue, in the finger and in the model of it, C.
        contact_m2k_w: contact resistance in the scene; None for that of a bare finger on this material.

    Raises:
        KeyError: no such material.
    """
    finger = SimulatedFinger.with_deep_tissue_at(deep_c)
    link = 1.0 / (PLATE_FINGER_M2K_W + finger.half_m2k_w)
    balance = finger.balance_w_m2k.copy()
    balance[0, 0] -= link
    to_plate = np.eye(len(finger.heat_j_m2k))[:, :1] * link
    advance, drive = exact_step(balance, finger.heat_j_m2k, np.hstack((to_plate, finger.known_w_m2[:, None])))
    scene = SceneSkin(body=Body(deep_c=deep_c, arterial_c=deep_c + 1.0), fingers=1)
    neutral_c = plate_c = scene.state().surface_c[0]
    skin_c = finger.at_rest_c(PLATE_FINGER_M2K_W, plate_c)
    touched = Touched.of(name)
    touched = touched if contact_m2k_w is None else replace(touched, contact_m2k_w=contact_m2k_w)
    early = round(lead_s / STEP_S)
    felt = [finger.felt_c(skin_c)]
    for step in range(-early, round(seconds / STEP_S)):
        if step < 0:
            wanted_c = contact_c(neutral_c, touched, object_c)
        else:
            scene.touch(0, touched, object_c)
            state = scene.step()
            wanted_c = state.surface_c[0] + state.flux_w_m2[0] * PLATE_CONTACT_M2K_W
        wanted_c = neutral_c + share * (wanted_c - neutral_c)
        change_k = min(max(wanted_c, COMFORT.low_c), COMFORT.high_c) - plate_c
        plate_c += min(max(change_k, -faster * PLATE_COOLING_K_S * STEP_S), faster * PLATE_HEATING_K_S * STEP_S)
        skin_c = advance @ skin_c + drive @ np.array([plate_c, 1.0])
        felt.append(finger.felt_c(skin_c))
    return (np.array(felt) - felt[0])[early:]
