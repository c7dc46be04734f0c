"""Rows that the operator site records and consoles read."""

from typing import Self

from common.faults.fault import Fault
from common.limits import GAP_S
from common.recording.recorded_row import FingerNumber, Finite, Five, FixedFive, Row, Whole


class RenderingInput(Row):
    """The input of a tick. The touch is the newest of operator/touch before it; here is its sequence number."""

    time_s: Finite
    session: Whole
    """Number of the session, 0 without one; each session numbers its own events."""
    fault_cleared: bool
    """Whether a person has cleared the fault since the last tick."""
    engaged: bool
    """Whether both sites permit outputs to act, and the exoskeleton reports that its drives are on."""
    gap_ns: Whole | None
    """Time since the last accepted touch packet, ns; None before the first of the session."""
    touch: Whole | None
    """Sequence number of the newest accepted touch packet of the session, fresh or not."""
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

    @property
    def located(self) -> bool:
        """Whether hand and fingertips were measured recently enough to render to them."""
        return self.time_s - min(self.pose_s, self.heights_s) <= GAP_S

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read what `pack` wrote; raises ValueError if the payload is something else."""
        try:
            return super().unpack(payload)
        except ValueError as error:
            raise ValueError(f"not a record of rendering input: {error}") from None


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
