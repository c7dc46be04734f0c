"""Computes the fingers' temperatures in the scene, with one batched product every 10 ms (first stage of Fig. 5).

The modelled finger touches what the remote finger touches, and the plate's set-point follows from it. Each finger has
the smallest model that its touch needs, and none once it is at rest again.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from common.fingers import FINGERS
from common.scenes.materials import Material
from operator_site.thermal.model_selection import RUNGS, choose, rung_table
from operator_site.thermal.skin_model import (
    OUTPUTS,
    STEP_S,
    SkinModel,
    SkinStep,
    Touched,
    contact_resistance_m2k_w,
    refined,
    skin_step,
)
from operator_site.thermal.tissue import Body, Floats, rest

AT_REST_K = 0.03
"""Largest departure of any cell of a free finger that is at rest, K."""
FLUX = np.array([0.0, 0.0, 0.0, 0.0, 1.0])
"""Selects the flux among the outputs of a step."""
LOOK_EVERY = 10
"""Steps between two checks whether fingers are at rest."""
RESUMES_S = 0.5
"""Longest interruption of a contact after which the object still has the heat that it exchanged before, s.

Lost packets interrupt a contact for 0.1 s to 0.3 s. In 0.5 s a finger hardly reaches another place.
"""


@dataclass(frozen=True, slots=True)
class SkinState:
    """Skin temperatures, C, and `flux_w_m2`, positive into the finger; one value for each finger."""

    epidermis_c: list[float]
    """Mean of the epidermis: the felt temperature T1."""
    dermis_c: list[float]
    subcutis_c: list[float]
    surface_c: list[float]
    flux_w_m2: list[float]


@lru_cache(maxsize=256)
def touched_object(conductivity_w_mk: float, density_kg_m3: float, specific_heat_j_kgk: float) -> Touched | None:
    """Return the object with these constants, rounded to 1 %; None if they are out of range.

    Rounding lets a slightly different estimate of the same object reuse its matrices. A difference of 1 % in a constant
    is far below the JND of a finger.
    """
    known = (
        0.01 <= conductivity_w_mk <= 1000.0
        and 1.0 <= density_kg_m3 <= 25_000.0
        and 100.0 <= specific_heat_j_kgk <= 10_000.0
    )
    if not known:
        return None
    k, rho, c = (
        math.exp(round(math.log(value) * 100.0) / 100.0)
        for value in (conductivity_w_mk, density_kg_m3, specific_heat_j_kgk)
    )
    return Touched(k, rho, c, contact_resistance_m2k_w(k))


def prepare(known: Iterable[Material], air_w_m2k: float = Body().air_w_m2k) -> None:
    """Solve the skin on materials beforehand, because 0.4 ms each are too long for the tick of the first touch."""
    rung_table()
    for kind in known:
        touched = touched_object(kind.conductivity_w_mk, kind.density_kg_m3, kind.specific_heat_j_kgk)
        for model in RUNGS:
            skin_step(model, touched, air_w_m2k)


class SceneSkin:
    """Skin of the operator's fingers in the scene."""

    def __init__(self, model: SkinModel | None = None, body: Body | None = None, fingers: int = len(FINGERS)) -> None:
        """Begin with all fingers at rest.

        Args:
            model: model of all fingers at all times; None selects the smallest accurate one for each touch.
            body: surroundings of the fingers.
            fingers: number of fingers.
        """
        self.body = body or Body()
        self._fixed = model
        self._rest = rest(self.body)
        self._rest_row = np.array([*self._rest.layers_c, self._rest.surface_c, self._rest.flux_w_m2])
        self._touched: list[Touched | None] = [None] * fingers
        self._object_c = np.full(fingers, self.body.air_c)
        self.models: list[SkinModel | None] = [model] * fingers
        """Present model of each finger; None at rest."""
        self._steps = 0
        self._left: list[tuple[int, Touched | None, Floats]] = [(0, None, np.zeros(0))] * fingers
        """Number of the step at which each finger last left an object, the object, and departures of its cells, K."""
        self._x = np.zeros((fingers, 0))
        self._at_rest = SkinState(*np.tile(self._rest_row, (fingers, 1)).T.tolist())
        self._size(model.states if model else 0)

    def touch(self, finger: int, touched: Touched | None, object_c: float, *, exact: bool = False) -> None:
        """Set the object that a finger touches, or None, and the object's temperature, C.

        The first contact sets the object's cells to its temperature. During contact, a better estimate of the
        temperature shifts the cells. A better estimate of the material keeps their departures, because the cells of
        all materials lie at the same multiples of the depth that heat has reached. A contact that begins again within
        RESUMES_S also keeps them. With `exact` values no estimate is better, and a change is another object.
        """
        before = self._touched[finger]
        if touched is None:
            if before is not None:
                start_k = self._object_c[finger] - self._rest.surface_c
                self._left[finger] = self._steps, before, self._ladder(finger) - start_k
                self._touched[finger] = None
                self._use(finger)
            return
        if (touched is before or touched == before) and object_c == self._object_c[finger]:
            return
        self._fit(finger, touched, object_c)
        ladder = self._ladder(finger)
        if before is None or exact:
            left, left_object, departures_k = self._left[finger]
            resumes = self._steps - left <= RESUMES_S / STEP_S and departures_k.shape == ladder.shape
            if exact:
                resumes = resumes and touched == left_object and object_c == self._object_c[finger]
            ladder[:] = object_c - self._rest.surface_c
            if resumes:
                ladder += departures_k
        else:
            ladder += object_c - self._object_c[finger]
        self._touched[finger] = touched
        self._object_c[finger] = object_c
        self._use(finger)

    def settle(self, finger: int) -> None:
        """Bring the skin of a free finger to rest."""
        self._x[finger] = 0.0

    def step(self) -> SkinState:
        """Advance all fingers by one step of 10 ms."""
        self._steps += 1
        states = self._x.shape[1]
        if not states:
            return self._at_rest
        both = np.matmul(self._advance, self._x[:, :, None])[:, :, 0] + self._advance_offset
        self._x = both[:, :states]
        if self._fixed is None and self._steps % LOOK_EVERY == 0:
            self._come_to_rest()
        return SkinState(*both[:, states:].T.tolist())

    def state(self) -> SkinState:
        """Return the present state with the flux of the present contact."""
        return SkinState(*(np.matmul(self._read, self._x[:, :, None])[:, :, 0] + self._offset).T.tolist())

    def _ladder(self, finger: int) -> Floats:
        """Return the cells of the object that a finger touches, as departures, K; a view."""
        model = self.models[finger]
        assert model is not None
        return self._x[finger, model.skin_cells : model.states]

    def _fit(self, finger: int, touched: Touched, object_c: float) -> None:
        """Give a finger the model that a touch needs, unless it has one as large or larger."""
        old = self.models[finger]
        if self._fixed is not None or old == RUNGS[-1]:
            return
        surface = float(self._read[finger, 3] @ self._x[finger] + self._offset[finger, 3])
        new = choose(touched, object_c - surface).model
        if old is not None and RUNGS.index(new) <= RUNGS.index(old):
            return
        if new.states > self._x.shape[1]:
            self._size(new.states)
        if old is not None:
            self._x[finger, : new.states] = refined(self._x[finger, : old.states], old, new)
            if not old.ladder and new.ladder:
                self._x[finger, new.skin_cells : new.states] = self._object_c[finger] - self._rest.surface_c
        self.models[finger] = new

    def _come_to_rest(self) -> None:
        """Remove the models of free fingers that are at rest again."""
        away = np.abs(self._x).max(axis=1).tolist()
        for finger, model in enumerate(self.models):
            if model is not None and self._touched[finger] is None and away[finger] <= AT_REST_K:
                self.models[finger] = None
                self._x[finger] = 0.0
                self._use(finger)
        largest = max((model.states for model in self.models if model), default=0)
        if largest < self._x.shape[1]:
            self._size(largest)

    def _size(self, states: int) -> None:
        """Resize the arrays to the largest model in use; smaller models leave states empty."""
        n = len(self._touched)
        x = np.zeros((n, states))
        common = min(states, self._x.shape[1])
        x[:, :common] = self._x[:, :common]
        self._x = x
        self._read, self._offset = np.zeros((n, OUTPUTS, states)), np.zeros((n, OUTPUTS))
        self._advance, self._advance_offset = np.zeros((n, states + OUTPUTS, states)), np.zeros((n, states + OUTPUTS))
        self._used: list[SkinStep | None] = [None] * n
        for finger in range(n):
            self._use(finger)

    def _use(self, finger: int) -> None:
        """Set the matrices of a finger's present touch; one product gives the next state and its outputs."""
        model, touched = self.models[finger], self._touched[finger]
        states = self._x.shape[1]
        advance, read = self._advance[finger], self._read[finger]
        drift = np.zeros(states)
        if model is None:
            advance[:], read[:] = 0.0, 0.0
            offset = self._offset[finger] = self._rest_row
            self._used[finger] = None
        else:
            step = skin_step(model, touched, self.body.air_w_m2k)
            n = len(step.a)
            if self._used[finger] is not step:
                self._used[finger] = step
                advance[:], read[:] = 0.0, 0.0
                advance[:n, :n], read[:, :n] = step.a, step.c
                advance[states:] = read @ advance[:states]
            self._x[finger, n:] = 0.0
            inputs = np.array([self._rest.flux_w_m2, self._object_c[finger] - self._rest.surface_c])
            drift[:n] = step.b @ inputs
            # The outputs at rest are the offset; the flux at rest is also an input, so subtract it.
            offset = self._offset[finger] = self._rest_row + step.d @ inputs - FLUX * self._rest.flux_w_m2
        self._advance_offset[finger] = np.concatenate((drift, read @ drift + offset))
