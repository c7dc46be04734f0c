"""Simulates the touches of the thermal study independently of the product: objects, plates and quality of contact."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from remote_site.thermal.calibration.thermal_calibration import USUAL_LEAK_PER_S, fit_thermal
from remote_site.thermal.heater_control import OFFSETS_K, STAGGER_K
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.touch_start import RecordedTouch, find_touch
from remote_site.traces.trace_files import ThermalTrace
from sim_sensors.physics.ssr_converter import NOISE_C
from sim_sensors.physics.thermal_touch import TOUCH_SPREAD
from sim_sensors.traces.simulated_touch import BLOCK_M, simulate_hand

FOUR = ("aluminium", "ceramic_tile", "pvc", "pine")
TWELVE = (*FOUR, "copper", "carbon_steel", "glass", "acrylic", "rubber", "cork", "pu_foam", "skin_dermis")
PREHEAT_K = OFFSETS_K[0]
EQUAL_K = (PREHEAT_K,) * len(STAGGER_K)
STAGGERED_K = tuple(PREHEAT_K + stagger_k for stagger_k in STAGGER_K)
"""Pre-heat of each finger's plate above ambient in a session, K; see `heater_control`."""
AMBIENT_C = 23.0
NEAR_K = (-3.0, 3.0)
"""Usual range of the objects' temperatures above ambient, K, also in calibration."""
SECONDS = 7.05
"""Duration of every touch, s; slightly longer than the last judged time."""


@dataclass(frozen=True, slots=True)
class Situation:
    """Touched objects, and conditions of the touches.

    Attributes:
        material: material of the objects.
        seed: seed of all random draws.
        touches: number of objects, each touched once.
        preheats_k: each finger's plate above ambient, K.
        offset_c: range of the object's temperature above ambient, K.
        thickness_m: thickness of the objects, m.
        contact_spread: standard deviation of ln(contact conductance) from touch to touch.
        later: time after contact at which the force changes, s, and the remaining share of the force; None for none.
        seconds: time in contact, s.
    """

    material: str
    seed: int
    touches: int
    preheats_k: tuple[float, ...] = (PREHEAT_K,)
    offset_c: tuple[float, float] = NEAR_K
    thickness_m: float = BLOCK_M
    contact_spread: float = TOUCH_SPREAD
    later: tuple[float, float] | None = None
    seconds: float = SECONDS


@dataclass(frozen=True, slots=True)
class Hand:
    """One object touched by one or more fingers, with its true material and temperature, C."""

    material: str
    object_c: float
    fingers: tuple[RecordedTouch, ...]


def touched(situation: Situation) -> list[Hand]:
    """Simulate all touches of a situation."""
    hands = simulate_hand(
        situation.material,
        situation.seed,
        situation.preheats_k,
        touches=situation.touches,
        seconds=situation.seconds,
        ambient_c=AMBIENT_C,
        offset_c=situation.offset_c,
        thickness_m=situation.thickness_m,
        contact_spread=situation.contact_spread,
        later=situation.later,
    )
    found = []
    for number, traces in enumerate(hands):
        fingers = []
        for trace in traces:
            name = f"{situation.material} {number}"
            touch = find_touch(ThermalTrace(trace.time_s, trace.sensor_c, trace.force_n, trace.ambient_c, name=name))
            if touch is None:
                raise ValueError(f"{name}: the simulated finger touched nothing")
            fingers.append(touch)
        found.append(Hand(situation.material, float(traces[0].object_c or 0.0), tuple(fingers)))
    return found


def noisier(hands: Sequence[Hand], noise_k: float, seed: int) -> list[Hand]:
    """Return the same touches with white noise of this standard deviation, K, instead of the simulator's own noise.

    A noise below the simulator's own leaves the touches unchanged.
    """
    more_k = float(np.sqrt(max(noise_k**2 - NOISE_C**2, 0.0)))
    if more_k == 0.0:
        return list(hands)
    chance = np.random.default_rng([seed, 77])
    found = []
    for hand in hands:
        fingers = []
        for finger in hand.fingers:
            sensor_c = finger.trace.sensor_c + more_k * chance.standard_normal(len(finger.trace.sensor_c))
            again = find_touch(replace(finger.trace, sensor_c=sensor_c))
            assert again is not None, "contact is found by force, which is unchanged"
            fingers.append(again)
        found.append(replace(hand, fingers=tuple(fingers)))
    return found


def calibration_touches(
    materials: Sequence[str], touches: int, seed: int, noise_k: float = NOISE_C, seconds: float = SECONDS
) -> dict[str, list[Hand]]:
    """Simulate labelled touches of each material."""
    return {
        material: noisier(touched(Situation(material, seed, touches, seconds=seconds)), noise_k, seed + number)
        for number, material in enumerate(materials)
    }


def calibrated(hands: Mapping[str, Sequence[Hand]], *, labelled: bool = True) -> MaterialTable:
    """Return the table of the product's own calibration; `labelled` is whether it knows the objects' temperatures."""
    listed: dict[str, list[tuple[RecordedTouch, float | None]]] = {
        material: [(hand.fingers[0], hand.object_c if labelled else None) for hand in each]
        for material, each in hands.items()
    }
    return fit_thermal("simulated touches", listed, USUAL_LEAK_PER_S).table
