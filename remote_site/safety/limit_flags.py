"""The limits that act on a finger of the telemanipulator, its heater or the whole hand."""

from enum import IntFlag


class Limit(IntFlag):
    """Which limits acted on a finger (PLANE on all)."""

    RELEASED = 1
    """Not engaged, motion or measurements missing, or a fault: stop, then retreat."""
    PLANE_RANGE = 2
    PLANE_SPEED = 4
    HEIGHT_RANGE = 8
    HEIGHT_SPEED = 16
    FORCE = 32
    """Not lowered further, or taken back, because of the contact force."""
    FORCE_UNKNOWN = 64
    """No fresh measurement of the telemanipulator: it is not moved blindly."""
    HEATER_CONTACT = 128
    SENSOR_UNKNOWN = 256
    """No fresh, plausible or moving sensor reading: heater off."""
    SENSOR_TEMPERATURE = 512
    DOSE = 1024
    HEATER_RANGE = 2048
    APPROACH = 4096
    """Let go and not yet where the operator's hand is: the hand comes slowly, the finger is not lowered before."""
    ENERGY = 8192
    """Not lowered further because of the work already left in what is touched."""
    HEATER_TEST = 16384
    """The sensor did not answer its heater, or faults named it repeatedly: no drive but a test pulse."""


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
"""Their bits as plain integers: an enumeration takes five times as long, in every tick and for each finger."""


def limit_names(bits: int) -> tuple[str, ...]:
    """Names of the limits in one finger's `limited`, for people to read."""
    return tuple(str(limit.name).lower() for limit in Limit if bits & limit)
