"""Table 1 again: six surfaces matched by what a stroke feels like, real ones with virtual or remote ones."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from sim_sensors.surface import SurfaceProfile, make_profile, surface_kind
from studies.paper_tables import MATCHED, MATCHING_OF, beside
from studies.remote_stroke import remote_stroke
from studies.rendered_hand import TICK_S
from studies.rendered_stroke import SHOWN_N_M, FingertipCourse, VirtualSurface, rendered_stroke
from studies.simulated_finger import Array
from studies.stroke_features import Typical, motor_features, surface_features
from studies.stroke_path import LENGTH_M, measured
from studies.texture_observer import LAPSE, PATTERN, Features, matching
from teletaction.make_tables import CONSTANTS

SURFACES = tuple(MATCHED)
FINE_RISE = math.log(1.10)
MORE_LAPSE = 0.10
FOAM_SHARE = surface_kind("foam").stiffness_n_m / surface_kind("plain_pvc").stiffness_n_m
"""Stiffness of foam as a share of plain PVC's, which is as stiff as the display can show."""
BY_HAND = (
    Features(0.0),
    Features(1.2),
    Features(0.35),
    Features(0.5, PATTERN, math.log(2.0)),
    Features(0.5, PATTERN, math.log(4.0), 2.2),
    Features(0.5, PATTERN, math.log(8.0)),
)
"""In the order of SURFACES: what they might feel like, set by hand. They check the observer, they predict nothing."""

MEASURED, HAND_SET, OWN_STIFFNESS = "measured", "set by hand", "foam with its own stiffness"
IDEAL_MOTOR, BETWEEN, FINER = "motor that does what is wanted", "strength between grooves", "grooves from 10 % rise on"


@dataclass(frozen=True, slots=True)
class Strokes:
    """One realisation of the six surfaces, in the order of SURFACES: the real ones, and courses at the fingertip."""

    profiles: list[SurfaceProfile]
    sides: Mapping[str, list[FingertipCourse]]
    soft_foam: FingertipCourse


def strokes(seed: int, tell: Callable[[float], object]) -> Strokes:
    """Stroke all surfaces once on each side; the grooves of the virtual ones are where the real ones' are."""
    profiles = [
        make_profile(surface_kind(name), LENGTH_M, np.random.default_rng([seed, place]))
        for place, name in enumerate(SURFACES)
    ]
    virtual = [rendered_stroke(_virtual(name, profile), seed) for name, profile in zip(SURFACES, profiles, strict=True)]
    soft = VirtualSurface(*CONSTANTS["foam"], stiffness_n_m=FOAM_SHARE * SHOWN_N_M)
    remote = []
    for place, name in enumerate(SURFACES):
        remote.append(remote_stroke(name, seed))
        tell((place + 1) / len(SURFACES))
    return Strokes(profiles, {"virtual": virtual, "remote": remote}, rendered_stroke(soft, seed))


def _virtual(name: str, profile: SurfaceProfile) -> VirtualSurface:
    """Grooved PVC is PVC."""
    return VirtualSurface(*CONSTANTS.get(name, CONSTANTS["plain_pvc"]), profile.grooves_m)


def real_features(each: Strokes, *, typical: Typical = np.mean, stiffness: bool = False) -> list[Features]:
    """Of the real surfaces."""
    kinds = [surface_kind(name) for name in SURFACES]
    return [
        surface_features(kind, profile, typical=typical, ln_stiffness=math.log(kind.stiffness_n_m) * stiffness)
        for kind, profile in zip(kinds, each.profiles, strict=True)
    ]


def felt_features(courses: Sequence[FingertipCourse], **how: Any) -> list[Features]:
    """Of what the motor did; stiffness is not attended to."""
    return [motor_features(measured(course.speed_rad_s, TICK_S), TICK_S, **how) for course in courses]


def _wanted_features(courses: Sequence[FingertipCourse]) -> list[Features]:
    return [motor_features(measured(course.wanted_rad_s, TICK_S), TICK_S) for course in courses]


def _stiff_features(each: Strokes) -> list[Features]:
    """Of the virtual surfaces with the foam that gives way, each with the stiffness that was shown."""
    courses = [each.soft_foam, *each.sides["virtual"][1:]]
    return [
        motor_features(measured(course.speed_rad_s, TICK_S), TICK_S, ln_stiffness=_ln_stiffness(course))
        for course in courses
    ]


def _ln_stiffness(course: FingertipCourse) -> float:
    force_n, depth_m = measured(course.force_n, TICK_S), measured(course.depth_m, TICK_S)
    return math.log(float(np.mean(force_n)) / float(np.mean(depth_m)))


def cases(each: Strokes) -> dict[tuple[str, str], tuple[Sequence[Features], Sequence[Features]]]:
    """Features of both sets, real ones first, by side and by how they are taken."""
    found: dict[tuple[str, str], tuple[Sequence[Features], Sequence[Features]]] = {
        ("virtual", HAND_SET): (BY_HAND, BY_HAND)
    }
    plain = real_features(each)
    for side, courses in each.sides.items():
        found[side, MEASURED] = plain, felt_features(courses)
        found[side, IDEAL_MOTOR] = plain, _wanted_features(courses)
        found[side, FINER] = plain, felt_features(courses, least_rise=FINE_RISE)
        found[side, BETWEEN] = real_features(each, typical=np.median), felt_features(courses, typical=np.median)
    found["virtual", OWN_STIFFNESS] = real_features(each, stiffness=True), _stiff_features(each)
    soft = replace(BY_HAND[0], ln_stiffness=math.log(FOAM_SHARE)), *BY_HAND[1:]
    found["virtual", f"{HAND_SET}, {OWN_STIFFNESS}"] = soft, soft
    return found


def matching_rows(all_strokes: Sequence[Strokes], seed: int, draws: int) -> list[dict[str, Any]]:
    """How often each surface is matched, mean over the realisations, beside the paper's."""
    shares: dict[tuple[str, str], list[list[float]]] = {}
    for number, each in enumerate(all_strokes):
        for case, (real, felt) in cases(each).items():
            shares.setdefault(case, []).append(matching(real, felt, seed + number, draws, lapse=0.0))
    rows = []
    for (side, features), found in shares.items():
        means: Array = np.mean(found, axis=0)
        for surface, share in zip(SURFACES, means.tolist(), strict=True):
            row = {"side": side, "features": features, "surface": surface}
            more = 100.0 * _with_lapse(share, MORE_LAPSE)
            beside_paper = beside(_with_lapse(share, LAPSE), MATCHED[surface], MATCHING_OF)
            rows.append(row | beside_paper | {"with_10_percent_lapse": more})
    return rows


def _with_lapse(share: float, lapse: float) -> float:
    return (1.0 - lapse) * share + lapse / len(SURFACES)


def feature_rows(each: Strokes) -> list[dict[str, Any]]:
    """What was measured of one realisation; ln intensity above the mean of its six."""
    rows = []
    for side, features in (
        ("real", real_features(each)),
        *((side, felt_features(c)) for side, c in each.sides.items()),
    ):
        middle = float(np.mean([one.ln_intensity for one in features]))
        for surface, one in zip(SURFACES, features, strict=True):
            values = asdict(one) | {"ln_intensity": one.ln_intensity - middle}
            del values["ln_stiffness"]
            rows.append({"side": side, "surface": surface, **values})
    return rows
