"""Rows that the operator site records and consoles read."""

from typing import Generic, TypeVar

from msgspec import Struct

from common.faults.fault import Fault
from common.recording.recorded_row import FingerNumber, Finite, Five, FixedFive, Row, Whole

_T = TypeVar("_T")


class InputFields(Struct, Generic[_T], array_like=True, forbid_unknown_fields=True):
    """Input of one tick of the rendering. The touch is a packet, or its sequence number."""

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


class RecordedInput(InputFields[Whole], Row):
    """The input of a tick. The touch is the newest of operator/touch before it; here is its sequence number."""


class Rendered(Row):
    """What left for the devices in a tick, when it was written, and its input."""

    engaged: bool
    age_s: Finite | None
    """Of the touch."""
    force_n: Five[Finite]
    motor_rpm: Five[Finite]
    plate_set_c: Five[Finite]
    peltier: Five[Finite]
    limits: Five[Whole]
    fault: Fault | None
    x_m: float
    y_m: float
    z_m: FixedFive[float]
    plate_c: FixedFive[float]
    sequence: Whole | None
    """Of the touch."""
    written_s: Finite


class Skin(Row):
    """Temperatures and heat flux of the skin model."""

    felt_c: Five[Finite]
    surface_c: Five[Finite]
    flux_w_m2: Five[Finite]


class Played(Row):
    """An impulse began: the event's number and kind."""

    ident: Whole
    kind: Whole
    finger: FingerNumber


class Clock(Row):
    """Comparison with the clock of the remote site; the uncertainty is null before the first."""

    offset_ns: Whole
    uncertainty_ns: Whole | None
    round_trip_ns: Whole
