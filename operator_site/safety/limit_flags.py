"""Flags of the limits that act on one finger's outputs at the operator site."""

from enum import IntFlag

RATE_ROUNDING_K = 1e-6
"""A set-point that misses its rate by rounding only is not reported as limited."""


class Limit(IntFlag):
    """Which limits acted on a finger."""

    RELEASED = 1
    """Not engaged, input stale, or a fault: outputs are going to neutral."""
    FORCE_RANGE = 2
    FORCE_RAMP = 4
    MOTOR_RANGE = 8
    PLATE_RANGE = 16
    PLATE_RATE = 32
    PLATE_TEMPERATURE = 64
    """Plate at the edge of its profile or of the fault limit: drive cut."""
    DOSE = 128
    PLATE_UNKNOWN = 256
    """No fresh reading of the plate: drive off."""
    DRIVE_RANGE = 512
    STIFFNESS = 1024
    """The surface is stiffer than the exoskeleton may show, and is shown softer; found by the renderer."""
    PASSIVITY = 2048
    """The finger has not put in the energy that the force could give out: force let go."""
    PLATE_TEST = 4096
    """Faults have named this plate repeatedly: no drive but a test pulse, until that has moved it."""


def limit_names(bits: int) -> tuple[str, ...]:
    """Names of the limits in one finger's `limited`, for people to read."""
    return tuple(str(limit.name).lower() for limit in Limit if bits & limit)
