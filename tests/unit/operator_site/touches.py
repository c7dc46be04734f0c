"""Touch packets, and the input of a tick of the rendering, made from the values of a test."""

from collections.abc import Iterable
from typing import Any

from msgspec.structs import replace

from common.fingers import FINGERS
from common.wire.messages import NO_TOUCH, Event, Touch, TouchRow, pack_rows
from common.wire.packets import LinkState, N
from operator_site.recorded_rows import RenderingInput

INDEX = FINGERS.index("index")
ALL = range(N)
UNNAMED = ("",) * N


def rows(fingers: Iterable[int] = ALL, **values: float) -> list[TouchRow]:
    """Fields of these fingers; everything else is 0."""
    return [NO_TOUCH._replace(**values) if finger in fingers else NO_TOUCH for finger in ALL]


def touch(*events: Event, sequence: int = 1, materials: tuple[str, ...] = UNNAMED, **values: float) -> Touch:
    """A packet of the index finger alone."""
    return Touch(7, sequence, 1, LinkState.ENGAGED, pack_rows(rows([INDEX], **values)), materials, events)


NEUTRAL = RenderingInput(
    time_s=10.0,
    session=7,
    fault_cleared=False,
    engaged=True,
    gap_ns=0,
    touch=None,
    x_m=0.0,
    y_m=0.0,
    z_m=(0.01,) * N,
    pose_s=10.0,
    heights_s=10.0,
    plate_c=(33.0,) * N,
    plate_age_s=(0.0,) * N,
    device_faults=(),
)


def tick_input(**changes: Any) -> RenderingInput:
    """Engaged, with a free hand and plates of 33 C, but for these changes."""
    return replace(NEUTRAL, **changes)
