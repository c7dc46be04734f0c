"""A fingertip on a virtual object: rendered from the object's true constants, felt on the simulated TactTip."""

from collections.abc import Sequence

import numpy as np

from studies.lowering import UP_M, height_m
from studies.simulated_finger import STEP_S, Array
from studies.virtual_touch import resting_on, touch_packet
from teletaction.testbed.rendered_fingers import TICK_S, RenderedFingers

REST_S = 10.0
"""The finger lies on its neutral plate for so long before the touch: nothing changes any more."""
DEPTH_M = 0.0025
"""How deep it rests in the object: 1 N at the stiffness that is shown."""
EVERY = round(STEP_S / TICK_S)


def rendered_touches(
    names: Sequence[str], object_c: float, seconds: float, seed: int, *, known_ahead: bool = False
) -> dict[str, Array]:
    """Change of the felt temperature every STEP_S from contact on, K; up to five objects at once, a finger each.

    Args:
        names: materials or aliases.
        object_c: temperature of all objects, C.
        seconds: how long they are touched.
        seed: of the plates' sensors.
        known_ahead: whether rendering knows the objects before they are touched, as those of a virtual world may be.
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
