"""Soft tissue of a scene's object, and the nodules in it."""

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from common.files.strict_model import StrictModel

BENEATH_M = 0.0015
"""Least tissue between a nodule and the rigid base, m."""
Tilt = Annotated[float, Field(ge=-2.0, le=2.0)]


class Nodule(StrictModel):
    """A stiff sphere in tissue.

    `x_m` and `y_m` are its place on the bench, m, `size_m` its diameter, m, and `depth_m` the tissue over its top, m.
    `ratio` is its Young's modulus over that of the tissue.
    """

    name: str = Field(min_length=1, max_length=40)
    x_m: float
    y_m: float
    size_m: float = Field(ge=0.004, le=0.020)
    depth_m: float = Field(ge=0.002, le=0.015)
    ratio: float = Field(ge=1.0, le=20.0)


class Tissue(StrictModel):
    """Tissue that stiffens, in a layer over a rigid base; its object's stiffness holds at a depth of 2 mm.

    The force grows with the power `exponent` of depth. Stiffness varies naturally by `variation`, as a standard
    deviation of its logarithm, over a length of `variation_m`, m. The surface slopes by `tilt_deg` along x and y, from
    the object's middle, and breathes with the amplitude `breath_m`, m. A finger that strokes drags the tissue along by
    `friction`, the coefficient of friction.
    """

    layer_m: float = Field(ge=0.010, le=0.100)
    exponent: float = Field(default=1.5, ge=1.2, le=3.0)
    variation: float = Field(default=0.0, ge=0.0, le=0.3)
    variation_m: float = Field(default=0.020, ge=0.005, le=0.100)
    tilt_deg: tuple[Tilt, Tilt] = (0.0, 0.0)
    breath_m: float = Field(default=0.0, ge=0.0, le=0.0015)
    breaths_per_min: float = Field(default=14.0, ge=4.0, le=30.0)
    friction: float = Field(default=0.0, ge=0.0, le=1.0)
    nodules: tuple[Nodule, ...] = ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [nodule.name for nodule in self.nodules]
        if len(set(names)) != len(names):
            raise ValueError("two nodules have the same name")
        for index, nodule in enumerate(self.nodules):
            if nodule.depth_m + nodule.size_m + BENEATH_M > self.layer_m:
                raise ValueError(f"nodule {nodule.name!r} does not fit into a layer of {self.layer_m} m")
            for other in self.nodules[:index]:
                if math.dist(_middle(nodule), _middle(other)) < 0.5 * (nodule.size_m + other.size_m):
                    raise ValueError(f"nodules {other.name!r} and {nodule.name!r} overlap")
        return self


def _middle(nodule: Nodule) -> tuple[float, float, float]:
    return nodule.x_m, nodule.y_m, nodule.depth_m + 0.5 * nodule.size_m
