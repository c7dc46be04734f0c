"""Reproduces Table 2 of the paper: pairs of real, virtual and remote objects compared by temperature."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from studies.observer.paper_tables import COMPARED, COMPARING_OF, beside
from studies.observer.thermal_observer import Answers, answers_about
from studies.pieces import Piece
from studies.touches.ideal_plate import ideal_plate_touch
from studies.touches.real_touch import real_touch
from studies.touches.remote_touch import remote_touch
from studies.touches.rendered_touch import rendered_touches
from studies.touches.simulated_finger import STEP_S, Array

OBJECTS = {"a": "aluminium", "c": "ceramic", "p": "pvc", "w": "wood"}
PAIRS = ("a-w", "a-p", "c-w", "p-w", "a-c")
"""Pairs of objects of the paper, and the additional pair a-c."""
OBJECT_C = 25.0
DWELLS_S = (2.0, 3.0, 5.0)
USUAL_S = 3.0
SHOWN_EVERY_S = 0.1
KNOWN_AHEAD = "virtual, known ahead"
"""Side on which the plate starts before the touch, because a virtual environment knows the object ahead."""

Courses = Mapping[str, list[Array]]
"""Changes of the felt temperature in an object's touches, K, from contact, by the object's letter."""


Course = tuple[str, str, Array]
"""Side, letter of the object, and change of the felt temperature in one touch, K."""


def course_pieces(seeds: int, seed: int) -> list[Piece]:
    """Return pieces that touch all objects on each side; remote touches are repeated for `seeds` seeds.

    The other sides need one touch, because the noise of a plate's sensor does not reach the finger.
    """
    remote: list[Piece] = [(_remote, (letter, seed + done)) for done in range(seeds) for letter in OBJECTS]
    return [*remote, (_real, ()), (_virtual, ("virtual", seed)), (_virtual, (KNOWN_AHEAD, seed))]


def courses(found: Iterable[Course]) -> dict[str, Courses]:
    """Group touches by side and object."""
    sides: dict[str, dict[str, list[Array]]] = {side: {} for side in ("real", "virtual", KNOWN_AHEAD, "remote")}
    for side, letter, course in found:
        sides[side].setdefault(letter, []).append(course)
    return dict(sides)


def _real() -> list[Course]:
    return [("real", letter, real_touch(name, OBJECT_C, max(DWELLS_S))) for letter, name in OBJECTS.items()]


def _virtual(side: str, seed: int) -> list[Course]:
    felt = rendered_touches(list(OBJECTS.values()), OBJECT_C, max(DWELLS_S), seed, known_ahead=side == KNOWN_AHEAD)
    return [(side, letter, felt[name]) for letter, name in OBJECTS.items()]


def _remote(letter: str, seed: int) -> list[Course]:
    return [("remote", letter, remote_touch(OBJECTS[letter], OBJECT_C, max(DWELLS_S), seed))]


def changes_k(touches: list[Array], dwell_s: float) -> list[float]:
    """Return the change of the felt temperature in each touch after this dwell time, K."""
    return [float(change_k[round(dwell_s / STEP_S)]) for change_k in touches]


def pair_answers(objects: Courses, pair: str, dwell_s: float) -> Answers:
    """Return the answers about a pair of objects."""
    first, second = pair.split("-")
    return answers_about(changes_k(objects[first], dwell_s), changes_k(objects[second], dwell_s))


def answer_rows(sides: Mapping[str, Courses]) -> list[dict[str, Any]]:
    """Return each predicted share beside the paper's."""
    rows = []
    for side, objects in sides.items():
        for pair in PAIRS:
            counts = COMPARED.get(side.partition(",")[0], {}).get(pair, (None,) * 3)
            for dwell_s in DWELLS_S:
                shares = pair_answers(objects, pair, dwell_s)._asdict()
                for (answer, share), count in zip(shares.items(), counts, strict=True):
                    row = {"side": side, "pair": pair, "dwell_s": dwell_s, "first_is_felt": answer}
                    rows.append(row | beside(share, count, COMPARING_OF))
    return rows


def course_rows(sides: Mapping[str, Courses]) -> list[dict[str, Any]]:
    """Return the mean change of the felt temperature over time."""
    every = round(SHOWN_EVERY_S / STEP_S)
    return [
        {"side": side, "object": OBJECTS[letter], "time_s": STEP_S * step, "change_k": float(change_k)}
        for side, objects in sides.items()
        for letter, touches in objects.items()
        for step, change_k in enumerate(np.mean(touches, axis=0))
        if step % every == 0
    ]


def ablation_rows() -> list[dict[str, Any]]:
    """Return the answers after 3 s with one parameter changed, on a real object and on an ideal plate."""
    cases: list[tuple[str, str, dict[str, float], dict[str, str]]] = [("as it is", "", {}, {})]
    cases += [("wood is", "oak", {}, {"w": "oak"})]
    cases += [("contact", f"{1e3 * r:g} K m²/kW", {"contact_m2k_w": r}, {}) for r in (5e-4, 1e-3, 2e-3, 3e-3)]
    cases += [("deep tissue", "35.5 °C", {"deep_c": 35.5}, {})]
    cases += [("plate", f"{faster:g} times faster", {"faster": faster}, {}) for faster in (2.0, 4.0)]
    rows = []
    for varied, value, changed, other in cases:
        for side, touch in (("real", real_touch), ("ideal plate", ideal_plate_touch)):
            if side == "real" and "faster" in changed:
                continue
            objects = {
                letter: [touch(name, OBJECT_C, USUAL_S, **changed)] for letter, name in (OBJECTS | other).items()
            }
            for pair in PAIRS:
                shares = {
                    f"{name}_percent": 100.0 * share
                    for name, share in pair_answers(objects, pair, USUAL_S)._asdict().items()
                }
                rows.append({"varied": varied, "value": value, "side": side, "pair": pair, **shares})
    return rows
