"""Rows that the remote site records."""

from common.faults.fault import Fault
from common.recording.recorded_row import FingerNumber, Finite, Five, Row, Whole


class Gate(Row):
    """What left for the devices in a tick."""

    x_m: float
    y_m: float
    z_m: Five[float]
    heater: Five[Finite]
    """Drive, -1..1."""
    limits: Five[Whole]
    fault: Fault | None


class SentEvent(Row):
    """What was identified and travels as an event."""

    ident: Whole
    kind: Whole
    finger: FingerNumber
    time_ns: Whole
    value: Finite
    name: str


class Thermal(Row):
    """Identification of the object under a finger; the stiffness is null while it is not yet known."""

    finger: FingerNumber
    status: Whole
    best: str | None
    probability: float | None
    object_c: float | None
    object_c_sd: float | None
    rate_per_s: float | None
    exponential_object_c: float | None
    exponential_material: str | None
    reason: str | None
    roughness_v: float | None
    stiffness_n_m: float | None
