"""Steps of a simulated hand's script in a scene."""

from typing import Annotated, Literal

from pydantic import Field

from common.files.strict_model import StrictModel
from common.fingers import FINGERS, FingerName

Reach = Annotated[float, Field(ge=-0.655, le=0.655)]
"""Position of the hand on the bench along one axis, m."""
Places = Annotated[tuple[Reach, ...], Field(min_length=1, max_length=100)]


class Move(StrictModel):
    """Move at hover height until the hand's x is at fraction `u` of the object's length."""

    act: Literal["move"]
    object: str
    u: float = Field(default=0.5, ge=0.0, le=1.0)


class Touch(StrictModel):
    """Lower all fingers until they are in contact."""

    act: Literal["touch"]


class Hold(StrictModel):
    """Rest in contact for `seconds`, s."""

    act: Literal["hold"]
    seconds: float = Field(gt=0.0, le=120.0)


class Stroke(StrictModel):
    """Slide in contact to fraction `u` of `to_object` at `speed_mm_s` along the path, mm/s."""

    act: Literal["stroke"]
    to_object: str
    u: float = Field(default=0.5, ge=0.0, le=1.0)
    speed_mm_s: float = Field(default=50.0, ge=5.0, le=200.0)


class Lift(StrictModel):
    """Raise all fingers to hover height."""

    act: Literal["lift"]


class Tap(StrictModel):
    """Lower and lift quickly, `times` times, without rest."""

    act: Literal["tap"]
    times: int = Field(default=1, ge=1, le=20)


class Presses(StrictModel):
    """Touch, rest for `hold_s`, s, and lift at each position of the hand: all of `x_m`, in order, for each of `y_m`.

    The operator moves the fingers to `depth_m`, m, below the bench; an object stops them earlier. Before each touch the
    hand hovers for `wait_s`, s. Only `fingers` touch; the others stay up.
    """

    act: Literal["presses"]
    x_m: Places
    y_m: Places
    hold_s: float = Field(gt=0.0, le=120.0)
    depth_m: float = Field(default=0.004, gt=0.0, le=0.010)
    wait_s: float = Field(default=0.0, ge=0.0, le=120.0)
    fingers: tuple[FingerName, ...] = Field(default=FINGERS, validate_default=True, min_length=1)


class Strokes(StrictModel):
    """For each of the hand's `y_m`: touch, slide in contact from one end of `x_m` to the other and back, lift."""

    act: Literal["strokes"]
    x_m: tuple[Reach, Reach]
    y_m: Places
    speed_mm_s: float = Field(default=50.0, ge=5.0, le=200.0)


class Wait(StrictModel):
    """Hover for `seconds`, s, while the thermal sensor re-heats."""

    act: Literal["wait"]
    seconds: float = Field(gt=0.0, le=120.0)


Step = Annotated[Move | Touch | Hold | Stroke | Lift | Tap | Presses | Strokes | Wait, Field(discriminator="act")]
