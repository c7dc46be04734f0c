"""Defines the flags of the limits that act on one finger's outputs at the operator site."""

from enum import IntFlag

RATE_ROUNDING_K = 1e-6
"""Largest shortfall of a rate-limited set-point that is not reported as limited, K; allows for rounding."""


class Limit(IntFlag):
    """Limits that acted on a finger."""

    RELEASED = 1
    """Not engaged, input stale or a fault: outputs ramp to neutral."""
    FORCE_RANGE = 2
    FORCE_RAMP = 4
    MOTOR_RANGE = 8
    PLATE_RANGE = 16
    PLATE_RATE = 32
    PLATE_TEMPERATURE = 64
    """Plate at the edge of its profile or of the fault limit: drive off."""
    DOSE = 128
    PLATE_UNKNOWN = 256
    """No fresh reading of the plate: drive off."""
    DRIVE_RANGE = 512
    STIFFNESS = 1024
    """The surface is stiffer than the exoskeleton may display, and the renderer displays it softer."""
    PASSIVITY = 2048
    """The finger has not put in the energy that the force could release: force reduced."""
    PLATE_TEST = 4096
    """Repeated faults named this plate: no drive except a test pulse, until the pulse has moved it."""


def limit_names(bits: int) -> tuple[str, ...]:
    """Return the readable names of the limits in one finger's `limited` bits."""
    return tuple(str(limit.name).lower() for limit in Limit if bits & limit)
