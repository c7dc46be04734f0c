"""Reproduces Table 1 of the paper: real surfaces matched with virtual or remote ones by the features of a stroke."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from common.limits import MOTOR_FLOOR_RPM, MOTOR_MAX_RPM
from common.scenes.surfaces import surface_kind
from sim_sensors.physics.motor import RPM_PER_RAD_S
from sim_sensors.physics.surface import SurfaceProfile, make_profile, relief_of
from studies.observer.paper_tables import MATCHED, MATCHING_OF, beside
from studies.observer.remote_stroke import remote_stroke
from studies.observer.stroke_features import motor_features, surface_features
from studies.observer.texture_observer import LAPSE, PATTERN, Features, confusion, matching
from studies.touches.rendered_stroke import SHOWN_N_M, FingertipCourse, VirtualSurface, left_to_itself, rendered_stroke
from studies.touches.simulated_finger import Array
from studies.touches.stroke_path import FORCE_N, LENGTH_M, SLOW_M_S, measured

SURFACES = tuple(MATCHED)
FOAM_SHARE = surface_kind("foam").stiffness_n_m / surface_kind("plain_pvc").stiffness_n_m
"""Stiffness of foam as a share of plain PVC's, which has the largest displayed stiffness."""
BY_HAND = (
    Features(0.0),
    Features(1.2),
    Features(0.35),
    Features(0.5, PATTERN, math.log(2.0)),
    Features(0.5, PATTERN, math.log(4.0), 2.2),
    Features(0.5, PATTERN, math.log(8.0)),
)
"""Plausible features set by hand, in the order of SURFACES; they check the observer model and predict nothing."""

MEASURED, HAND_SET, OWN_STIFFNESS = "measured", "set by hand", "foam with its own stiffness"
LEFT_ALONE, IDEAL_MOTOR = "motor left to itself", "motor that does what is wanted"
BETWEEN, SLOWLY, BY_INTENSITY = "strength between grooves", "stroked at 30 mm/s", "rendered by felt intensity"
BY_ROUGHNESS, BY_ROUGHNESS_SLOWLY = "constants by roughness", "constants by roughness, 30 mm/s"

Sets = tuple[Sequence[Features], Sequence[Features]]
"""Features of the real and of the displayed surfaces."""


@dataclass(frozen=True, slots=True)
class Strokes:
    """One realisation of the six surfaces, in the order of SURFACES.

    Attributes:
        profiles: the real surfaces.
        virtual, remote: courses at the fingertip.
        varied: courses over virtual surfaces by variation: SLOWLY, BY_INTENSITY, OWN_STIFFNESS, BY_ROUGHNESS,
            BY_ROUGHNESS_SLOWLY.
    """

    profiles: Sequence[SurfaceProfile]
    virtual: Sequence[FingertipCourse]
    remote: Sequence[FingertipCourse]
    varied: Mapping[str, Sequence[FingertipCourse]]

    @property
    def sides(self) -> dict[str, Sequence[FingertipCourse]]:
        """Courses at the fingertip by side."""
        return {"virtual": self.virtual, "remote": self.remote}


def strokes(seed: int) -> Strokes:
    """Stroke all surfaces once in each way; virtual surfaces have their grooves where the real ones have them."""
    profiles = [
        make_profile(relief_of(name), LENGTH_M, np.random.default_rng([seed, place]))
        for place, name in enumerate(SURFACES)
    ]
    surfaces = [VirtualSurface.of(name, profile.grooves_m) for name, profile in zip(SURFACES, profiles, strict=True)]
    virtual = [rendered_stroke(surface, seed) for surface in surfaces]
    remote = [remote_stroke(name, seed) for name in SURFACES]
    soft, rough = replace(surfaces[0], stiffness_n_m=FOAM_SHARE * SHOWN_N_M), by_roughness(profiles)
    varied = {
        SLOWLY: [rendered_stroke(surface, seed, stroke_m_s=SLOW_M_S) for surface in surfaces],
        BY_INTENSITY: [rendered_stroke(surface, seed, vibration="intensity") for surface in surfaces],
        OWN_STIFFNESS: [rendered_stroke(soft, seed), *virtual[1:]],
        BY_ROUGHNESS: [rendered_stroke(surface, seed) for surface in rough],
        BY_ROUGHNESS_SLOWLY: [rendered_stroke(surface, seed, stroke_m_s=SLOW_M_S) for surface in rough],
    }
    return Strokes(profiles, virtual, remote, varied)


def by_roughness(profiles: Sequence[SurfaceProfile]) -> list[VirtualSurface]:
    """Return surfaces whose constants follow the strength of the real surfaces' fluctuation.

    ln motor speed is linear in ln strength. Plain PVC, the smoothest, has the lowest perceptible speed, and sandpaper
    the largest one of the motor. Between their grooves, grooved surfaces are plain PVC. The speed depends on the force
    alone: the real fluctuation hardly changes with the speed of a stroke.
    """
    strength = {
        name: surface_features(surface_kind(name).stiffness_n_m, profile).ln_intensity
        for name, profile in zip(SURFACES, profiles, strict=True)
    }
    smooth, rough = strength["plain_pvc"], strength["sandpaper"]
    found = []
    for name, profile in zip(SURFACES, profiles, strict=True):
        share = 0.0 if profile.grooves_m else (strength[name] - smooth) / (rough - smooth)
        rpm = MOTOR_FLOOR_RPM * (MOTOR_MAX_RPM / MOTOR_FLOOR_RPM) ** share
        found.append(VirtualSurface(0.0, rpm / RPM_PER_RAD_S / FORCE_N, profile.grooves_m))
    return found


def real_features(each: Strokes, **how: Any) -> list[Features]:
    """Return the features of the real surfaces, without their stiffness."""
    return [
        surface_features(surface_kind(name).stiffness_n_m, profile, **how)
        for name, profile in zip(SURFACES, each.profiles, strict=True)
    ]


def felt_features(courses: Sequence[FingertipCourse], **how: Any) -> list[Features]:
    """Return the features of the motor's courses, without the displayed stiffness."""
    return [motor_features(measured(course.speed_rad_s), **how) for course in courses]


def cases(each: Strokes) -> dict[tuple[str, str], Sets]:
    """Return both sets by side and by variation of stroking, rendering or feeling."""
    real, by_hand = real_features(each), list(BY_HAND)
    found: dict[tuple[str, str], Sets] = {("virtual", HAND_SET): (by_hand, by_hand)}
    for side, courses in each.sides.items():
        wanted = [course._replace(speed_rad_s=course.wanted_rad_s) for course in courses]
        found[side, MEASURED] = real, felt_features(courses)
        found[side, IDEAL_MOTOR] = real, felt_features(wanted)
        found[side, LEFT_ALONE] = real, felt_features([left_to_itself(course) for course in courses])
        found[side, BETWEEN] = real_features(each, typical=np.median), felt_features(courses, typical=np.median)
    slow = {"stroke_m_s": SLOW_M_S}
    stroked: dict[str, dict[str, Any]] = {SLOWLY: slow, BY_ROUGHNESS: {}, BY_ROUGHNESS_SLOWLY: slow, BY_INTENSITY: {}}
    for name, how in stroked.items():
        found["virtual", name] = real_features(each, **how), felt_features(each.varied[name], **how)
    found["virtual", OWN_STIFFNESS] = _with_own_stiffness(real, each.varied[OWN_STIFFNESS])
    soft = [replace(BY_HAND[0], ln_stiffness=math.log(FOAM_SHARE)), *BY_HAND[1:]]
    found["virtual", f"{HAND_SET}, {OWN_STIFFNESS}"] = soft, soft
    return found


def _with_own_stiffness(real: Sequence[Features], courses: Sequence[FingertipCourse]) -> Sets:
    """Return both sets with stiffness: the real surfaces' own, and the displayed one."""
    stiff = [
        replace(one, ln_stiffness=math.log(surface_kind(name).stiffness_n_m))
        for name, one in zip(SURFACES, real, strict=True)
    ]
    felt = [
        replace(one, ln_stiffness=math.log(float(measured(course.force_n).mean() / measured(course.depth_m).mean())))
        for one, course in zip(felt_features(courses), courses, strict=True)
    ]
    return stiff, felt


def matching_rows(all_strokes: Sequence[Strokes], seed: int, draws: int) -> list[dict[str, Any]]:
    """Return the mean share of matches of each surface over all realisations, beside the paper's."""
    shares: dict[tuple[str, str], list[list[float]]] = {}
    for number, each in enumerate(all_strokes):
        for case, (real, felt) in cases(each).items():
            shares.setdefault(case, []).append(matching(real, felt, seed + number, draws, lapse=0.0))
    rows = []
    for (side, features), found in shares.items():
        means: Array = np.mean(found, axis=0)
        for surface, share in zip(SURFACES, means.tolist(), strict=True):
            row = {"side": side, "features": features, "surface": surface}
            shown = (1.0 - LAPSE) * share + LAPSE / len(SURFACES)
            rows.append(row | beside(shown, MATCHED[surface], MATCHING_OF))
    return rows


def confusion_rows(each: Strokes, seed: int, draws: int) -> list[dict[str, Any]]:
    """Return the shares of pairs of real and displayed surfaces for one realisation with measured features."""
    rows = []
    for side in each.sides:
        shares = confusion(*cases(each)[side, MEASURED], seed, draws, LAPSE)
        for surface, row in zip(SURFACES, 100.0 * shares, strict=True):
            percents = {f"{name}_percent": float(share) for name, share in zip(SURFACES, row, strict=True)}
            rows.append({"side": side, "real_surface": surface, **percents})
    return rows
