"""Five fingers' temperatures in the explored scene, one batched product for each 10 ms (first stage of Fig. 5).

The finger here touches what the remote finger touches; what the plate must show follows from it.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from common.fingers import FINGERS
from common.materials import contact_resistance_m2k_w
from operator_site.skin import (
    DEFAULT_MODEL,
    Body,
    Floats,
    SkinModel,
    SkinStep,
    Touched,
    half_cell_m2k_w,
    resting,
    skin_step,
)


@dataclass(frozen=True, slots=True)
class SkinState:
    """What each finger feels, arrays of 5; `flux_w_m2` is positive into the finger."""

    epidermis_c: Floats
    """Mean of the epidermis: the felt temperature T1."""
    dermis_c: Floats
    subcutis_c: Floats
    surface_c: Floats
    flux_w_m2: Floats


def touched_object(conductivity_w_mk: float, density_kg_m3: float, specific_heat_j_kgk: float) -> Touched | None:
    """The object that these constants describe, rounded to 1 %; None when they describe none.

    Rounding lets a slightly different estimate of the same object reuse its matrices: a difference of
    1 % in a constant is far below what a finger tells apart.
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


class SceneSkin:
    """Skin of the operator's fingers as the scene would have it."""

    def __init__(self, model: SkinModel = DEFAULT_MODEL, body: Body | None = None, fingers: int = len(FINGERS)):
        self.model = model
        self.body = body or Body()
        self._free = skin_step(model, None, self.body.air_w_m2k)
        self._steps: list[SkinStep] = [self._free] * fingers
        self._touched: list[Touched | None] = [None] * fingers
        self._object_c = np.full(fingers, self.body.air_c)
        self._x = np.tile(resting(model, self.body), (fingers, 1))
        self._skin = slice(model.ladder, None)
        self._half_cell = half_cell_m2k_w(model)
        edges = np.cumsum([model.ladder, model.epidermis, model.dermis, model.subcutis])
        self._mean = np.zeros((3, self._x.shape[1]))
        for layer, (start, end) in enumerate(pairwise(edges)):
            self._mean[layer, start:end] = 1.0 / (end - start)
        self._a = np.stack([step.a for step in self._steps])
        self._drift = np.zeros_like(self._x)
        self._conductance = np.zeros(fingers)
        self._neighbour = np.full(fingers, -1)
        self._outside = np.full(fingers, self.body.air_c)
        for finger in range(fingers):
            self._use(finger)

    def touch(self, finger: int, touched: Touched | None, object_c: float) -> None:
        """Say what a finger is on: nothing (None) or an object of a temperature, C.

        The first contact sets the object's cells to its temperature. While contact lasts, a better estimate of
        the temperature shifts them, and of the material keeps their departure from it: the cells of two materials
        lie at the same multiples of the depth that heat has reached, so the picture carries over.
        """
        if touched is None:
            if self._touched[finger] is not None:
                self._touched[finger] = None
                self._use(finger)
            return
        if touched == self._touched[finger] and object_c == self._object_c[finger]:
            return
        ladder = self._x[finger, : self.model.ladder]
        if self._touched[finger] is None:
            ladder[:] = object_c
        else:
            ladder += object_c - self._object_c[finger]
        self._touched[finger] = touched
        self._object_c[finger] = object_c
        self._use(finger)

    def step(self) -> SkinState:
        """Advance all fingers by one step of 10 ms."""
        self._x = np.matmul(self._a, self._x[:, :, None])[:, :, 0] + self._drift
        return self.state()

    def state(self) -> SkinState:
        """The present state, with the flux that the present contact drives."""
        means = self._x @ self._mean.T
        first = self._x[:, self.model.ladder]
        rows = np.arange(len(first))
        neighbour = np.where(self._neighbour >= 0, self._x[rows, self._neighbour], self._outside)
        flux = self._conductance * (neighbour - first)
        return SkinState(means[:, 0], means[:, 1], means[:, 2], first + flux * self._half_cell, flux)

    def _use(self, finger: int) -> None:
        touched = self._touched[finger]
        step = self._free if touched is None else skin_step(self.model, touched)
        outside_c = self.body.air_c if touched is None else float(self._object_c[finger])
        self._a[finger] = step.a
        self._drift[finger] = step.b @ np.array([outside_c, self.body.arterial_c, self.body.deep_c])
        self._conductance[finger] = step.conductance_w_m2k
        self._neighbour[finger] = step.neighbour
        self._outside[finger] = outside_c
