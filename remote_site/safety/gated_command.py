"""The patient gate's output: what may reach the devices of the remote site."""

from dataclasses import dataclass

from common.faults.fault import Fault


@dataclass(slots=True)
class GatedCommand:
    """What may reach the telemanipulator and the heaters, and what the gate did."""

    ready: bool
    """False until the telemanipulator's place was measured once: no set-point may be sent before."""
    released: bool
    """Stop and retreat: the telemanipulator itself must hold the hand and let fingers only rise."""
    x_m: float
    y_m: float
    z_m: list[float]
    heater_drive: list[float]
    limited: list[int]
    """`Limit` bits of each finger."""
    fault: Fault | None
