"""Rows that the operator site records and consoles read."""

from common.faults.fault import Fault
from common.recording.recorded_row import FingerNumber, Finite, Five, FixedFive, Row, Whole


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
