"""The remote site and the operator site, with rules between fields."""

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from common import limits
from common.buses.can_address import CanAddress
from common.config.fingers import Addresses, Fingers
from common.config.link_models import OperatorLinkConfig, RemoteLinkConfig
from common.config.recording_models import ConsentConfig, RecordingConfig, require_own_file
from common.files.strict_model import StrictModel
from common.fingers import FINGERS
from common.logs import LogForm
from common.timing.timeouts import FASTEST_RATE_HZ, SLOWEST_RATE_HZ, check_ladder


class SiteConfig(StrictModel):
    """Fields that both sites' configurations share."""

    fingers: Fingers = Field(default=FINGERS, validate_default=True)
    rate_hz: float = Field(default=500.0, ge=SLOWEST_RATE_HZ, le=FASTEST_RATE_HZ)
    wait_for_devices_s: float = Field(default=5.0, ge=0.0, le=600.0)
    record: Path | None = None
    """MCAP file to record to; by default nothing is recorded."""
    recording: RecordingConfig = RecordingConfig()
    consent: ConsentConfig | None = None
    """The patient's answer; by default nobody has asked, and pain, picture and voice are not recorded."""
    status: Path | None = None
    """JSON file with the process's own figures, rewritten every second for health checks."""
    log: LogForm = "text"
    """Form of the log on standard error: text lines for people, or one JSON object a line."""

    def _check(self, serial: Mapping[str, Addresses], gap_s: float, age_s: float) -> None:
        for kind, addresses in serial.items():
            if set(addresses) != set(self.fingers):
                raise ValueError(
                    f"{kind}: has addresses for {', '.join(sorted(addresses)) or 'no finger'}, "
                    f"fingers says {', '.join(self.fingers)}"
                )
        every = [address for addresses in serial.values() for address in addresses.values()]
        twice = {address for address in every if every.count(address) > 1}
        if twice:
            raise ValueError(f"address {min(twice)} is given to two devices")
        check_ladder(self.rate_hz, gap_s, age_s)
        if self.record is not None and self.consent is not None and not self.consent.touch:
            raise ValueError("record names a file, but consent.touch is false: remove record")
        require_own_file(self.record, self.status)


class CalibrationConfig(StrictModel):
    """Calibrated look-up tables of the remote site, written by `teletaction calibrate`."""

    materials: Path
    surfaces: Path


class PatientConfig(StrictModel):
    """Limits of the patient side's gate, within `common.limits`."""

    contact_force_n: float = Field(default=limits.CONTACT_FORCE_N, gt=0.0, le=limits.CONTACT_FORCE_N)


class PatientSwitchConfig(StrictModel):
    """The patient's stop switch, a serial device."""

    port: str
    """A tty path or `socket://host:port`."""


class RemoteConfig(SiteConfig):
    """The remote site."""

    rate_hz: float = Field(default=250.0, ge=SLOWEST_RATE_HZ, le=FASTEST_RATE_HZ)
    """Rate of the loop, Hz, half of the operator site's: an object changes more slowly than a hand moves, and a tick
    costs more."""
    link: RemoteLinkConfig
    desk_port: int = Field(default=5608, ge=1, le=65535)
    """Loopback port for commands of a person at this site, such as an emergency stop (`teletaction session`)."""
    texture: Addresses
    thermal_sensors: Addresses
    telemanipulator: CanAddress
    calibration: CalibrationConfig
    patient: PatientConfig = PatientConfig()
    patient_switch: PatientSwitchConfig | None = None
    """The patient's stop switch; by default there is none. Once named, nothing moves without it."""

    @model_validator(mode="after")
    def _between_fields(self) -> "RemoteConfig":
        self._check(
            {"texture": self.texture, "thermal_sensors": self.thermal_sensors}, self.link.gap_s, self.link.max_age_s
        )
        switch = self.patient_switch
        if switch is not None and switch.port in (*self.texture.values(), *self.thermal_sensors.values()):
            raise ValueError(f"address {switch.port} is given to two devices")
        return self


VibrationScale = Literal["speed", "intensity"]
"""Quantity in which Eq. 1 and 2 are linear: motor speed, as in the paper, or perceived intensity."""


class RenderingConfig(StrictModel):
    """Rendering for the operator's fingers."""

    profile: Literal["comfort", "wide"] = "comfort"
    air_c: float = Field(default=25.0, ge=0.0, le=45.0)
    deep_c: float = Field(default=34.0, ge=25.0, le=38.0)
    """Temperature below the finger's skin, C: the only personal constant of the thermal model."""
    exoskeleton_damping_n_s_m: float = Field(default=2.0, ge=0.0, le=50.0)
    """Damping of the exoskeleton at a finger without a hand, N s/m. With the loop's period and the delay below it
    bounds the stiffness that can be displayed."""
    exoskeleton_delay_s: float = Field(default=0.004, ge=0.0, le=0.1)
    """Delay from measuring a height to the force that responds to it, s, beyond the loop's period."""
    vibration: VibrationScale = "speed"
    """Whether strokes and taps are matched in motor speed (Kron & Schmidt 2003) or in perceived intensity."""


class OperatorConfig(SiteConfig):
    """The operator site."""

    link: OperatorLinkConfig
    desk_port: int = Field(default=5609, ge=1, le=65535)
    """Loopback port for commands of the person at this site, such as an emergency stop (`teletaction session`)."""
    tacttip: Addresses
    exoskeleton: CanAddress
    rendering: RenderingConfig = RenderingConfig()
    feed_port: int | None = Field(default=None, ge=1, le=65535)
    """Loopback port where a console reads the session; by default there is none."""
    console_required_s: float = Field(default=0.0, ge=0.0, le=60.0)
    """Pause when the acting console was hidden, frozen or silent for this time while engaged, s; 0 disables it."""
    engage: bool = False
    """Engage as soon as both sites are ready, and again after a lost link, as a demonstration does. Otherwise a
    person has to request it each time."""

    @model_validator(mode="after")
    def _between_fields(self) -> "OperatorConfig":
        self._check({"tacttip": self.tacttip}, self.link.gap_s, self.link.max_age_s)
        return self
