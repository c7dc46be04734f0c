"""Simulated devices and the simulated network."""

from pathlib import Path

from pydantic import Field, model_validator

from common.config.fingers import Addresses, Fingers
from common.files.strict_model import StrictModel
from common.fingers import FINGERS
from common.logs import LogForm


class _SimulationConfig(StrictModel):
    fingers: Fingers = Field(default=FINGERS, validate_default=True)
    scene: str = "materials"
    seed: int = Field(default=0, ge=0)
    can_host: str = "127.0.0.1"
    can_port: int = Field(default=29536, ge=1, le=65535)
    fault_port: int | None = Field(default=None, ge=1, le=65535)
    """Loopback port for commands that inject faults; by default there is none."""
    record: Path | None = None
    status: Path | None = None
    log: LogForm = "text"


class SimPatientSwitchConfig(StrictModel):
    """The simulated stop switch of the patient."""

    port: str
    """`pty`, or `tcp:HOST:PORT` to listen on."""
    pressed_at_s: tuple[float, ...] = ()
    """Times at which the patient presses it, s, from the first movement of the telemanipulator."""
    reaction_s: float | None = Field(default=None, gt=0.0, le=5.0)
    """Reaction time with which the patient moves the pain slider, s; by default there is no slider."""


class SimCameraConfig(StrictModel):
    """The simulated network camera, which sends YUV4MPEG2."""

    port: str
    """`tcp:HOST:PORT` to listen on."""
    width: int = Field(default=640, ge=64, le=1920, multiple_of=8)
    height: int = Field(default=360, ge=64, le=1088, multiple_of=8)
    rate_hz: int = Field(default=15, ge=1, le=30)


class SimRemoteConfig(_SimulationConfig):
    """Simulated devices of the remote site; addresses are `pty` or `tcp:HOST:PORT` to listen on."""

    texture: Addresses
    thermal_sensors: Addresses
    patient_switch: SimPatientSwitchConfig | None = None
    camera: SimCameraConfig | None = None


class SimOperatorConfig(_SimulationConfig):
    """Simulated devices and the scripted hand of the operator site."""

    tacttip: Addresses
    seconds: float | None = Field(default=None, gt=0.0)
    """Duration of the hand's script once its exoskeleton is driven, s; by default without a limit."""


class SimNetworkConfig(StrictModel):
    """A simulated network between the operator, who connects to it, and the remote site, to which it connects."""

    network: str
    """Name of a network shipped with the program, or a path that ends in `.toml` or `.csv`."""
    bind: str = "127.0.0.1"
    base_port: int = Field(ge=1, le=65529)
    to_host: str = "127.0.0.1"
    to_base_port: int = Field(default=5600, ge=1, le=65529)
    seed: int = Field(default=0, ge=0)
    wait_for_start: bool = False
    """Start the network's timetable at the command `start` on the fault port instead of at the process's start."""
    fault_port: int | None = Field(default=None, ge=1, le=65535)
    status: Path | None = None
    log: LogForm = "text"

    @model_validator(mode="after")
    def _can_be_started(self) -> "SimNetworkConfig":
        if self.wait_for_start and self.fault_port is None:
            raise ValueError("wait_for_start needs a fault_port for the command `start`")
        return self
