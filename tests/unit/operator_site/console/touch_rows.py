"""Touch rows and samples for tests of the map."""

from common.fingers import FINGER_Y_M, FINGERS
from common.wire.messages import NO_TOUCH, ExplorationMode, ThermalStatus, TouchRow
from operator_site.console.map.finger_samples import Sample

INDEX = FINGERS.index("index")


def row(finger: int, x_m: float, y_m: float, **fields: float) -> TouchRow:
    """A finger in contact at a place of the bench, resting, with nothing known of the object but what is given."""
    known = {
        "mode": float(ExplorationMode.QUIESCENT),
        "contact": 1.0,
        "x_m": x_m,
        "y_m": y_m - FINGER_Y_M[finger],
        "stiffness_ln_sd": 10.0,
        "object_c_sd": 50.0,
        "thermal_status": float(ThermalStatus.DECIDING),
    } | fields
    return NO_TOUCH._replace(**known)


def hand(**rows: TouchRow) -> list[TouchRow]:
    """All five rows; fingers that are not named are free."""
    return [rows.get(finger, NO_TOUCH) for finger in FINGERS]


def sample(quantity: str, number: int, x_m: float, y_m: float, value: float, variance: float, name: str = "") -> Sample:
    """The only sample of a touch."""
    return Sample(quantity, (INDEX, number, 0), number, INDEX, x_m, y_m, float(number), value, variance, name)
