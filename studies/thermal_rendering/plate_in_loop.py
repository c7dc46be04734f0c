"""Heat through all of the operator site: rendering, gate, controller, Peltiers, plate, and the simulated finger on it.

The same touches at every tick length, with a good thermistor and with a bad one, are compared with the finger on the
object itself. An ideal plate with the rate limit is also compared with one that follows at once. While these two differ
by more than the tolerance, the rate does not allow better. From then on the error must stay within twice the tolerance.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from common.fingers import FINGERS
from common.scenes.materials import materials
from studies.pieces import Piece, chunks
from studies.thermal_rendering.felt_error import felt_error, tolerance_k
from studies.touches.ideal_plate import ideal_plate_touch
from studies.touches.real_touch import real_touch
from studies.touches.simulated_finger import STEP_S, Array
from studies.touches.virtual_touch import resting_on, touch_packet
from teletaction.testbed.rendered_fingers import RenderedFingers

TICKS_S = (0.001, 0.002, 0.005, 0.010, 0.020, 0.050)
BAD_NOISE_K, BAD_DELAY_S = 0.1, 0.1
TEMPERATURES_C = (25.0, 37.0)
SECONDS = 10.0
REST_S = 8.0
STEADY_S = 3.0
"""Duration of the end of a touch, s; a plate that still swings then does not come to rest."""
UP_M = 0.006
"""Height at which the hand stays, m; only the packets say what is touched."""
STIFFNESS_N_M = 400.0
AT_ONCE = 1000.0
"""Rate of a plate that is always at its set-point, as a multiple of a TactTip's."""


def rendered_courses(
    names: Sequence[str], object_c: float, tick_s: float, noise_k: float, delay_s: float, seed: int
) -> tuple[Array, Array]:
    """Change of the felt temperature on each object every STEP_S from contact on, K, and the plate temperatures, C."""
    hand = RenderedFingers(seed, tick_s=tick_s, noise_k=noise_k, delay_s=delay_s)
    touching = touch_packet(2, {finger: resting_on(name, object_c, STIFFNESS_N_M) for finger, name in enumerate(names)})
    free = touch_packet(1, {})
    for _ in range(round(REST_S / tick_s)):
        hand.step(free, 0.0, UP_M)
    before_c = hand.plates.felt_c.copy()
    time_s, felt, plate = [0.0], [hand.plates.felt_c - before_c], [hand.plates.plate_c.copy()]
    for tick in range(round(SECONDS / tick_s)):
        hand.step(touching, 0.0, UP_M)
        time_s.append(tick_s * (tick + 1))
        felt.append(hand.plates.felt_c - before_c)
        plate.append(hand.plates.plate_c.copy())
    grid = STEP_S * np.arange(round(SECONDS / STEP_S) + 1)
    felt_k, plate_c = (
        np.array([np.interp(grid, time_s, column) for column in np.array(kept).T[: len(names)]])
        for kept in (felt, plate)
    )
    return felt_k, plate_c


def loop_pieces(
    names: Sequence[str] | None = None,
    temperatures_c: Sequence[float] = TEMPERATURES_C,
    ticks_s: Sequence[float] = TICKS_S,
    seed: int = 0,
) -> list[Piece]:
    """A piece for each temperature and five materials; all materials by default."""
    every = sorted(materials()) if names is None else list(names)
    return [
        (loop_rows, (five, object_c, tuple(ticks_s), seed))
        for object_c in temperatures_c
        for five in chunks(every, len(FINGERS))
    ]


def loop_rows(five: Sequence[str], object_c: float, ticks_s: Sequence[float], seed: int) -> Iterator[dict[str, Any]]:
    """Errors of every touch of up to five materials, one on each finger."""
    true = [real_touch(name, object_c, SECONDS) for name in five]
    ideal = [ideal_plate_touch(name, object_c, SECONDS) for name in five]
    at_once = [ideal_plate_touch(name, object_c, SECONDS, faster=AT_ONCE) for name in five]
    for tick_s in ticks_s:
        for noise_k, delay_s in ((0.0, 0.0), (BAD_NOISE_K, BAD_DELAY_S)):
            felt, plate = rendered_courses(five, object_c, tick_s, noise_k, delay_s, seed)
            for finger, name in enumerate(five):
                yield {
                    "object": name,
                    "object_c": object_c,
                    "tick_s": tick_s,
                    "noise_k": noise_k,
                    "delay_s": delay_s,
                    **_judged(felt[finger], plate[finger], true[finger], ideal[finger], at_once[finger]),
                }


def _judged(felt: Array, plate: Array, true: Array, ideal: Array, at_once: Array) -> dict[str, Any]:
    error, tolerance = felt_error(felt, true), tolerance_k(true)
    late = np.flatnonzero(np.abs(ideal - at_once) > tolerance)
    first = int(late[-1]) + 1 if len(late) else 0
    steady = plate[-round(STEADY_S / STEP_S) :]
    trend = np.polyval(np.polyfit(np.arange(len(steady)), steady, 2), np.arange(len(steady)))
    return {
        "error_k": error.largest_k,
        "beyond_k": error.beyond_k,
        "ideal_error_k": felt_error(ideal, true).largest_k,
        "rate_allows_from_s": STEP_S * first,
        "share_where_rate_allows": float((np.abs(felt - true) / tolerance)[first:].max()),
        "plate_swing_k": float(np.abs(steady - trend).max()),
    }
