"""What a scripted hand does in a scene, step by step."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field


class _Step(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Move(_Step):
    """Travel at hover height until the hand's x is at fraction `u` of the object's length."""

    act: Literal["move"]
    object: str
    u: float = Field(default=0.5, ge=0.0, le=1.0)


class Touch(_Step):
    """Lower all fingers until they are in contact."""

    act: Literal["touch"]


class Hold(_Step):
    """Rest in contact for `seconds`."""

    act: Literal["hold"]
    seconds: float = Field(gt=0.0, le=120.0)


class Stroke(_Step):
    """Slide in contact to fraction `u` of `to_object`, mm/s along the path."""

    act: Literal["stroke"]
    to_object: str
    u: float = Field(default=0.5, ge=0.0, le=1.0)
    speed_mm_s: float = Field(default=50.0, ge=5.0, le=200.0)


class Lift(_Step):
    """Raise all fingers to hover height."""

    act: Literal["lift"]


class Tap(_Step):
    """Lower and lift quickly, `times` times, without holding."""

    act: Literal["tap"]
    times: int = Field(default=1, ge=1, le=20)


class Wait(_Step):
    """Hover for `seconds`: the thermal sensor re-heats."""

    act: Literal["wait"]
    seconds: float = Field(gt=0.0, le=120.0)


Step = Annotated[Move | Touch | Hold | Stroke | Lift | Tap | Wait, Field(discriminator="act")]
