"""Computes from a scene and the operator's fingers the touch parameters that a remote site would identify.

Contact is geometric: the depth of a finger in an object gives its force. The exploration mode follows from force and
motion by the same mode detector as at the remote site. Every object is a half space, because a touch packet has no
thickness.
"""

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from common.exploration.exploration_mode import ModeDetector
from common.exploration.hand_motion import HandMotion
from common.fingers import FINGER_Y_M, FINGERS
from common.scenes.scene import Scene, SceneObject
from common.scenes.surfaces import surface_kind
from common.wire.messages import (
    MAX_EVENTS,
    NO_TOUCH,
    TOUCH_RANGES,
    Event,
    EventKind,
    ExplorationMode,
    ThermalStatus,
    Touch,
    TouchRow,
    pack_rows,
)
from common.wire.packets import LinkState
from common.wire.touch_summary import NOTHING, TouchSummary

_MOST_N = TOUCH_RANGES["contact_force_n"][1]
_Happening = tuple[EventKind, float, float]
"""Kind, time in s, and value of an event."""


@dataclass(frozen=True, slots=True)
class _Piece:
    """One object with its drawn grooves and its touch row."""

    thing: SceneObject
    stiffness_n_m: float
    grooves_x_m: tuple[float, ...]
    row: TouchRow
    """Exact values: standard deviations are 0."""
    summary: TouchSummary
    """Its material; there is no roughness without a texture sensor."""


@dataclass(slots=True)
class _Finger:
    """Exploration state of one finger with its last time and place."""

    exploration: ModeDetector
    time_s: float = 0.0
    x_m: float = math.nan
    row: TouchRow = NO_TOUCH
    material: str = ""
    summary: TouchSummary = NOTHING


class VirtualEnvironment:
    """Computes touches and events of all fingers over a scene. Pure: time is an argument, s."""

    def __init__(self, scene: Scene, fingers: Iterable[str], seed: int):
        """Draw the objects' temperatures and the distances of arbitrary grooves; the scene's script is not used."""
        self._pieces = _draw(scene, np.random.default_rng(seed))
        self._numbers = [FINGERS.index(finger) for finger in fingers]
        self._time_s = -math.inf
        self._events: tuple[Event, ...] = ()
        self._event_count = 0
        self._restart()

    def _restart(self) -> None:
        """Reset the fingers; event numbers continue, so that no new event is taken for an old one."""
        self._hand = HandMotion()
        self._fingers = {number: _Finger(ModeDetector(self._hand)) for number in self._numbers}

    def step(self, time_s: float, x_m: float, y_m: float, z_m: Iterable[float]) -> tuple[Event, ...]:
        """Take the hand's place and the height of each fingertip, m; return the events since the last step.

        The row of a finger above an object has the object's parameters already before contact, with contact 0 and
        mode free. Rendering may therefore begin early, because the next contact is known.
        """
        if time_s < self._time_s:  # the clock was set back
            self._restart()
        self._time_s = time_s
        self._hand.step(time_s, x_m, y_m)
        happened: list[tuple[int, _Happening]] = []
        for number, height_m in enumerate(z_m):
            if (finger := self._fingers.get(number)) is not None:
                piece = self._below(x_m, y_m + FINGER_Y_M[number])
                happened += [(number, what) for what in _move(finger, piece, time_s, x_m, y_m, height_m)]
        events = [
            Event(ident, kind, number, round(when_s * 1e9), 0, value)
            for ident, (number, (kind, when_s, value)) in enumerate(happened, self._event_count + 1)
        ]
        self._event_count += len(events)
        self._events = tuple(events[-MAX_EVENTS:])
        return self._events

    def packet(self, session: int, sequence: int, time_ns: int, state: LinkState) -> Touch:
        """Return the last step as a touch packet; each event is sent once, because none can be lost."""
        fingers = [self._fingers.get(number) for number in range(len(FINGERS))]
        rows = [NO_TOUCH if finger is None else finger.row for finger in fingers]
        names = tuple("" if finger is None else finger.material for finger in fingers)
        summaries = tuple(NOTHING if finger is None else finger.summary for finger in fingers)
        return Touch(session, sequence, time_ns, state, pack_rows(rows), names, self._events, summaries)

    def _below(self, x_m: float, y_m: float) -> _Piece | None:
        for piece in self._pieces:
            if piece.thing.covers(x_m, y_m):
                return piece
        return None


def _move(
    finger: _Finger, piece: _Piece | None, time_s: float, x_m: float, y_m: float, z_m: float
) -> Iterator[_Happening]:
    """Move a finger to its new place; yield the events on the way."""
    exploration = finger.exploration
    force_n = 0.0 if piece is None else piece.stiffness_n_m * max(0.0, piece.thing.height_m - z_m)
    mode = exploration.step(time_s, force_n, z_m)
    from_s, from_x_m = finger.time_s, finger.x_m
    finger.time_s, finger.x_m = time_s, x_m
    if piece is None:
        finger.row, finger.material, finger.summary = NO_TOUCH, "", NOTHING
        return
    pressed_n = min(force_n, _MOST_N)
    finger.row = piece.row._replace(mode=mode, contact=exploration.contact, contact_force_n=pressed_n, x_m=x_m, y_m=y_m)
    finger.material, finger.summary = piece.thing.material, piece.summary
    if exploration.began:
        yield EventKind.TAP, time_s, exploration.approach_m_s
    if mode is ExplorationMode.STROKING:
        for groove_x_m in _crossed(piece.grooves_x_m, from_x_m, x_m):
            share = (groove_x_m - from_x_m) / (x_m - from_x_m)
            yield EventKind.GROOVE, from_s + share * (time_s - from_s), piece.row.groove_rad_s


def _crossed(grooves_x_m: tuple[float, ...], from_x_m: float, to_x_m: float) -> tuple[float, ...]:
    """Return the grooves between two places, m, in the order of crossing."""
    first, last = bisect_right(grooves_x_m, from_x_m), bisect_right(grooves_x_m, to_x_m)
    return grooves_x_m[first:last] if first <= last else grooves_x_m[last:first][::-1]


def _draw(scene: Scene, rng: np.random.Generator) -> tuple[_Piece, ...]:
    """Draw the scene's objects; all objects of one body have one temperature."""
    offsets_c: dict[str, float] = {}
    return tuple(_piece(scene, thing, offsets_c, rng) for thing in scene.objects)


def _piece(scene: Scene, thing: SceneObject, offsets_c: dict[str, float], rng: np.random.Generator) -> _Piece:
    surface, material = surface_kind(thing.surface), scene.material(thing.material)
    stiffness_n_m = scene.virtual_stiffness_n_m or thing.stiffness
    offset_c = offsets_c.setdefault(thing.body or thing.name, rng.uniform(*thing.offset_c))
    grooves = surface.grooves
    row = NO_TOUCH._replace(
        surface_z_m=thing.height_m,
        stiffness_n_m=stiffness_n_m,
        k_tap=surface.k_tap,
        b_tap_per_s=surface.b_tap_per_s,
        k_stroke_v=surface.k_stroke_v,
        k_stroke_f=surface.k_stroke_f,
        groove_rad_s=grooves.impulse_rad_s if grooves else 0.0,
        b_groove_per_s=grooves.decay_per_s if grooves else 0.0,
        conductivity_w_mk=material.conductivity_w_mk,
        density_kg_m3=material.density_kg_m3,
        specific_heat_j_kgk=material.specific_heat_j_kgk,
        object_c=scene.ambient_c + offset_c if thing.absolute_c is None else thing.absolute_c,
        probability=1.0,
        thermal_status=ThermalStatus.IDENTIFIED,
    )
    places = grooves.draw(thing.length_m, rng) if grooves else []
    grooves_x_m = tuple(thing.x_m + place for place in places)
    summary = TouchSummary(((thing.material, 1.0),))
    return _Piece(thing, stiffness_n_m, grooves_x_m, row, summary)
