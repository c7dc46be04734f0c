"""Input of rendering in one tick, recorded and replayed exactly."""

from collections.abc import Callable
from typing import Generic, TypeVar

from msgspec import Struct
from msgspec.structs import asdict

from common.faults.fault import Fault
from common.limits import GAP_S
from common.recording.recorded_row import Finite, FixedFive, Row, Whole
from common.wire.messages import Touch

_T = TypeVar("_T")


class _Input(Struct, Generic[_T], array_like=True, forbid_unknown_fields=True):
    time_s: Finite
    session: Whole
    """Number of the session, 0 without one; each session numbers its own events."""
    fault_cleared: bool
    """Whether a person has cleared the fault since the last tick."""
    engaged: bool
    """Whether both sites permit outputs to act."""
    gap_ns: Whole | None
    """Time since the last accepted touch packet, ns; None before the first of the session."""
    touch: _T | None
    """The newest accepted touch packet of the session, fresh or not."""
    x_m: float
    y_m: float
    z_m: FixedFive[float]
    """Place of the hand and height of each fingertip, m."""
    pose_s: float
    heights_s: float
    """Times at which place and heights were measured, s; -inf before the first measurement."""
    plate_c: FixedFive[float]
    plate_age_s: FixedFive[float]
    """Last reading of each plate, C, NaN from a faulty sensor, and its age, s, infinite before the first reading."""
    device_faults: tuple[Fault, ...]
    """Faults of the modules."""


class RecordedInput(_Input[Whole], Row):
    """The input of a tick. The touch is the newest of operator/touch before it; here is its sequence number."""


class RenderingInput(_Input[Touch]):
    """One tick's input, five fingers each."""

    @property
    def located(self) -> bool:
        """Whether hand and fingertips were measured recently enough to render to them."""
        return self.time_s - min(self.pose_s, self.heights_s) <= GAP_S

    def pack(self) -> bytes:
        """Return the bytes for the recording; nothing is rounded, and the touch is its packet's sequence number."""
        touch = None if self.touch is None else self.touch.sequence
        return RecordedInput(**asdict(self) | {"touch": touch}).pack()

    @classmethod
    def unpack(cls, packed: bytes, touch_of: Callable[[int], Touch | None]) -> "RenderingInput":
        """Read what `pack` wrote.

        Args:
            packed: bytes of the recording.
            touch_of: returns the touch packet of a sequence number; None for a lost packet, which touches nothing.

        Raises:
            ValueError: it is something else.
        """
        try:
            found = RecordedInput.unpack(packed)
        except ValueError as error:
            raise ValueError(f"not a record of rendering input: {error}") from None
        return cls(**asdict(found) | {"touch": None if found.touch is None else touch_of(found.touch)})
