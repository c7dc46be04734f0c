"""The paper's Fig. 13: estimates of a remote aluminium block over time, by the paper's method and by this project's.

Both use the same readings of one simulated finger. The paper extrapolates the exponential response of the plate. It
takes the final value for the object's temperature, and the rate for the "virtual heat conductivity".
"""

from typing import Any

from sim_sensors.physics.fingertip import pressing_depth_m
from sim_sensors.physics.thermal_touch import AREA_M2
from studies.touches.lowering import height_m
from studies.touches.remote_touch import AT_M, FORCE_N
from studies.touches.teleoperation import block_of, scene_of
from teletaction.testbed.remote_fingers import RemoteFingers
from teletaction.testbed.rendered_fingers import TICK_S

MATERIAL = "aluminium"
OBJECT_C = 25.0
WARM_UP_S = 10.0
TOUCHED_S = 9.0
PAPER_S = 7.0
"""Time after contact at which the paper's figure takes its values, s."""
SHOWN_EVERY = 25
"""Ticks between two rows: 50 ms."""


def identification_rows(seed: int) -> list[dict[str, Any]]:
    """One row every 50 ms from contact on; None where a value is not known yet."""
    block = block_of(MATERIAL).model_copy(update={"absolute_c": OBJECT_C})
    hand, depth_m = RemoteFingers(scene_of(block), seed), pressing_depth_m(FORCE_N, block.stiffness)
    rows: list[dict[str, Any]] = []
    ticks, contact = 0, None
    while contact is None or ticks - contact <= round(TOUCHED_S / TICK_S):
        hand.step(AT_M, height_m(ticks * TICK_S - WARM_UP_S, depth_m))
        ticks += 1
        if contact is None and hand.touch.contact:
            contact = ticks
        if contact is not None and (ticks - contact) % SHOWN_EVERY == 0:
            rows.append({"time_s": TICK_S * (ticks - contact)} | _row(hand))
    return rows


def _row(hand: RemoteFingers) -> dict[str, Any]:
    answer = hand.touch.thermal.answer
    rate_per_s = answer.rate_per_s
    return {
        "sensor_c": hand.plate_c,
        "exponential_object_c": answer.exponential_object_c,
        "exponential_rate_per_s": rate_per_s,
        "virtual_heat_conductivity_per_m2_s": None if rate_per_s is None else rate_per_s / AREA_M2,
        "exponential_material": answer.exponential_material,
        "object_c": answer.object_c,
        "object_sd_k": answer.object_c_sd,
        "effusivity_j_m2ks05": answer.effusivity,
        "effusivity_ln_sd": answer.effusivity_ln_sd,
        "status": answer.status.name.lower(),
        "material": answer.material,
    }
