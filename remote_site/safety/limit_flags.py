"""Flags of the limits that act on a finger of the telemanipulator, its heater or the whole hand."""

from enum import IntFlag


class Limit(IntFlag):
    """Limits that acted on a finger; the PLANE limits act on all fingers."""

    RELEASED = 1
    """Stop and retreat: not engaged, motion or measurements missing, the patient's stop, or a fault."""
    PLANE_RANGE = 2
    PLANE_SPEED = 4
    HEIGHT_RANGE = 8
    HEIGHT_SPEED = 16
    FORCE = 32
    """The contact force keeps the finger from being lowered further, or raises it."""
    FORCE_UNKNOWN = 64
    """The finger does not move, because no fresh measurement of the telemanipulator exists."""
    HEATER_CONTACT = 128
    SENSOR_UNKNOWN = 256
    """The heater is off, because the sensor reading is old, implausible or does not change."""
    SENSOR_TEMPERATURE = 512
    DOSE = 1024
    HEATER_RANGE = 2048
    APPROACH = 4096
    """The hand approaches the operator's hand slowly after a release; the finger is not lowered before it arrives."""
    ENERGY = 8192
    """The residual work in the touched object keeps the finger from being lowered further."""
    HEATER_TEST = 16384
    """The heater gets only a test pulse: the sensor did not answer its heater, or had repeated faults."""


(
    RELEASED,
    PLANE_RANGE,
    PLANE_SPEED,
    HEIGHT_RANGE,
    HEIGHT_SPEED,
    FORCE,
    FORCE_UNKNOWN,
    HEATER_CONTACT,
    SENSOR_UNKNOWN,
    SENSOR_TEMPERATURE,
    DOSE,
    HEATER_RANGE,
    APPROACH,
    ENERGY,
    HEATER_TEST,
) = [limit.value for limit in Limit]
"""Bits of `Limit` as plain integers. Each tick uses them for each finger; an enumeration is five times slower."""


def limit_names(bits: int) -> tuple[str, ...]:
    """Return readable names of the limits in one finger's `limited`."""
    return tuple(str(limit.name).lower() for limit in Limit if bits & limit)
