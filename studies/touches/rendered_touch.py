"""Simulates fingertips on virtual objects, rendered from the objects' true constants on the simulated TactTip."""

from collections.abc import Sequence

import numpy as np

from studies.touches.lowering import UP_M, height_m
from studies.touches.simulated_finger import STEP_S, Array
from studies.touches.virtual_touch import resting_on, touch_packet
from teletaction.testbed.rendered_fingers import TICK_S, RenderedFingers

REST_S = 10.0
"""Time on the neutral plate before the touch, s; all temperatures are steady by then."""
DEPTH_M = 0.0025
"""Depth of the resting finger in the object, m: 1 N at the displayed stiffness."""
EVERY = round(STEP_S / TICK_S)


def rendered_touches(
    names: Sequence[str], object_c: float, seconds: float, seed: int, *, known_ahead: bool = False
) -> dict[str, Array]:
    """Return the change of the felt temperature every STEP_S from contact, K, for up to five objects, one per finger.

    Args:
        names: materials or aliases.
        object_c: temperature of all objects, C.
        seconds: duration of the touches, s.
        seed: seed of the plates' sensors.
        known_ahead: whether rendering knows the objects before the touch, as it may in a virtual environment.
    """
    hand = RenderedFingers(seed)
    objects = {finger: resting_on(name, object_c, hand.stiffest_n_m) for finger, name in enumerate(names)}
    untouched = {finger: known | {"mode": 0.0, "contact": 0.0} for finger, known in objects.items()}
    free, touching = touch_packet(1, untouched if known_ahead else {}), touch_packet(2, objects)
    for _ in range(round(REST_S / TICK_S)):
        hand.step(free, 0.0, UP_M)
    before_c, felt = hand.plates.felt_c.copy(), list[Array]()
    ticks, contact = 0, None
    while len(felt) <= round(seconds / STEP_S):
        z_m = height_m(ticks * TICK_S, DEPTH_M)
        contact = ticks if contact is None and z_m < 0.0 else contact
        if contact is not None and (ticks - contact) % EVERY == 0:
            felt.append(hand.plates.felt_c - before_c)
        hand.step(free if contact is None else touching, 0.0, z_m)
        ticks += 1
    courses = np.array(felt)
    return {name: courses[:, finger] for finger, name in enumerate(names)}
