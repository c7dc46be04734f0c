"""Configuration of each process: TOML, checked by pydantic with the rules between fields."""

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from common import limits
from common.can_line import CanAddress
from common.fingers import FINGERS
from common.keys import KEY_LENGTH

FingerName = Literal["thumb", "index", "middle", "ring", "little"]


def _each_once(fingers: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(fingers)) < len(fingers):
        raise ValueError("a finger is named twice")
    return fingers


Fingers = Annotated[tuple[FingerName, ...], Field(min_length=1, max_length=5), AfterValidator(_each_once)]
Addresses = dict[FingerName, str]
"""Where each finger's serial device is: a tty path or `socket://host:port`."""


class ConfigProblem(ValueError):
    """A configuration that cannot be used; the message names file, line and field."""


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class RemoteLinkConfig(_Section):
    """The remote site's side of the link. Curve keys are not an option: there is no way without."""

    bind: str = "127.0.0.1"
    base_port: int = Field(default=5600, ge=1, le=65531)
    keys: Path
    max_age_s: float = Field(default=limits.AGE_DEFAULT_S, gt=0.0, le=limits.AGE_MAX_S)
    gap_s: float = Field(default=limits.GAP_S, gt=0.0, le=limits.GAP_S)


class OperatorLinkConfig(_Section):
    """The operator site's side of the link."""

    host: str = "127.0.0.1"
    base_port: int = Field(default=5600, ge=1, le=65531)
    keys: Path
    remote_key: str | None = Field(default=None, min_length=KEY_LENGTH, max_length=KEY_LENGTH)
    """The remote site's public key; without it, the one that the key folder trusts under the name `remote`."""
    max_age_s: float = Field(default=limits.AGE_DEFAULT_S, gt=0.0, le=limits.AGE_MAX_S)
    gap_s: float = Field(default=limits.GAP_S, gt=0.0, le=limits.GAP_S)


class SiteConfig(_Section):
    """What the two sites' configurations share."""

    fingers: Fingers = Field(default=FINGERS, validate_default=True)
    rate_hz: float = Field(default=500.0, ge=100.0, le=1000.0)
    wait_for_devices_s: float = Field(default=5.0, ge=0.0, le=600.0)
    record: Path | None = None
    """MCAP file to record to; nothing is recorded without."""
    status: Path | None = None
    """JSON file with the process's own figures, rewritten every second; health checks read it."""

    def _check(self, serial: Mapping[str, Addresses], gap_s: float) -> None:
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
        if gap_s < 3.0 / self.rate_hz:
            raise ValueError(f"link.gap_s: {gap_s} s must cover three periods of rate_hz {self.rate_hz:g}")


class CalibrationConfig(_Section):
    """Calibrated look-up tables of the remote site, as `teletaction calibrate` writes them."""

    materials: Path
    surfaces: Path


class PatientConfig(_Section):
    """The patient side's gate, within the table of limits."""

    contact_force_n: float = Field(default=limits.CONTACT_FORCE_N, gt=0.0, le=limits.CONTACT_FORCE_N)


class RemoteConfig(SiteConfig):
    """The remote site."""

    link: RemoteLinkConfig
    texture: Addresses
    thermal_sensors: Addresses
    telemanipulator: CanAddress
    calibration: CalibrationConfig
    patient: PatientConfig = PatientConfig()

    @model_validator(mode="after")
    def _between_fields(self) -> "RemoteConfig":
        self._check({"texture": self.texture, "thermal_sensors": self.thermal_sensors}, self.link.gap_s)
        return self


class RenderingConfig(_Section):
    """What the operator is made to feel, and how."""

    profile: Literal["comfort", "wide"] = "comfort"
    air_c: float = Field(default=25.0, ge=0.0, le=45.0)
    deep_c: float = Field(default=34.0, ge=25.0, le=38.0)
    """Temperature below the finger's skin, C: the one personal constant of the thermal model."""
    max_stiffness_n_m: float = Field(default=400.0, gt=0.0, le=5000.0)
    """Stiffest contact rendered: what stays stable over the loop's own delay to the exoskeleton."""


class OperatorConfig(SiteConfig):
    """The operator site."""

    link: OperatorLinkConfig
    tacttip: Addresses
    exoskeleton: CanAddress
    rendering: RenderingConfig = RenderingConfig()
    engage: bool = False
    """Engage as soon as both sites are ready, as a demonstration does; otherwise somebody has to ask for it."""

    @model_validator(mode="after")
    def _between_fields(self) -> "OperatorConfig":
        self._check({"tacttip": self.tacttip}, self.link.gap_s)
        return self


class _SimulationConfig(_Section):
    fingers: Fingers = Field(default=FINGERS, validate_default=True)
    scene: str = "materials"
    seed: int = Field(default=0, ge=0)
    can_host: str = "127.0.0.1"
    can_port: int = Field(default=29536, ge=1, le=65535)
    record: Path | None = None
    status: Path | None = None


class SimRemoteConfig(_SimulationConfig):
    """Simulated devices of the remote site; addresses are `pty` or `tcp:HOST:PORT` to listen on."""

    texture: Addresses
    thermal_sensors: Addresses


class SimOperatorConfig(_SimulationConfig):
    """Simulated devices and the scripted hand of the operator site."""

    tacttip: Addresses
    seconds: float | None = Field(default=None, gt=0.0)
    """How long the hand works once its exoskeleton is driven; for ever without."""


M = TypeVar("M", bound=BaseModel)


def load_config(path: Path, model: type[M]) -> M:
    """Read a TOML file into `model`; relative paths in it count from the file's own folder.

    Raises:
        ConfigProblem: no such file, not TOML, or a field is missing, unknown or out of its rules.
    """
    try:
        text = path.read_text("utf-8")
        values = tomllib.loads(text)
    except OSError as error:
        raise ConfigProblem(f"{path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigProblem(f"{path}: not TOML: {error}") from None
    try:
        checked = model.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        line = _line_of(text, [str(part) for part in first["loc"]])
        message = first["msg"].removeprefix("Value error, ")
        raise ConfigProblem(f"{path}:{line}: {where + ': ' if where else ''}{message}") from None
    return _anchor(checked, path.parent)


def _line_of(text: str, location: list[str]) -> int:
    """Line of the deepest part of `location` that the file mentions; 1 when it mentions none."""
    found = 1
    lines = text.splitlines()
    for part in location:
        name = re.escape(part)
        pattern = re.compile(rf"^\s*\[.*\b{name}\b.*\]|^.*\b{name}\b\"?\s*=")
        for number in range(found, len(lines) + 1):
            if pattern.match(lines[number - 1]):
                found = number
                break
    return found


def _anchor(model: M, folder: Path) -> M:
    """Make relative paths count from `folder`."""
    changed: dict[str, object] = {}
    for name in type(model).model_fields:
        value = getattr(model, name)
        if isinstance(value, Path) and not value.is_absolute():
            changed[name] = folder / value
        elif isinstance(value, BaseModel):
            changed[name] = _anchor(value, folder)
    return model.model_copy(update=changed)


def to_toml(model: BaseModel) -> str:
    """The resolved configuration as TOML that `load_config` reads back; kept with every recording."""
    values = model.model_dump(mode="json", exclude_none=True)
    lines = [f"{key} = {_toml(value)}" for key, value in values.items() if not isinstance(value, dict)]
    for key, table in values.items():
        if isinstance(table, dict):
            lines += ["", f"[{key}]", *(f"{name} = {_toml(value)}" for name, value in table.items())]
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    # A JSON scalar or list of scalars is written the same way in TOML, but for this one character.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
