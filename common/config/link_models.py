"""The two ends of the link, its read-only client, and the tunnel over a rendezvous."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from common import limits
from common.files.strict_model import StrictModel
from common.link.keys import KEY_LENGTH
from common.logs import LogForm


class RemoteLinkConfig(StrictModel):
    """The remote site's side of the link. Curve keys are mandatory."""

    bind: str = "127.0.0.1"
    base_port: int = Field(default=5600, ge=1, le=65529)
    keys: Path
    max_age_s: float = Field(default=limits.AGE_DEFAULT_S, gt=0.0, le=limits.AGE_MAX_S)
    gap_s: float = Field(default=limits.GAP_S, gt=0.0, le=limits.GAP_S)
    deadband: bool = True
    """Omit touch packets whose change the operator would not perceive."""


class OperatorLinkConfig(StrictModel):
    """The operator site's side of the link."""

    host: str = "127.0.0.1"
    base_port: int = Field(default=5600, ge=1, le=65529)
    keys: Path
    remote_key: str | None = Field(default=None, min_length=KEY_LENGTH, max_length=KEY_LENGTH)
    """Public key of the remote site; by default the key that the key folder trusts under the name `remote`."""
    calibration: str | None = None
    """Required hash of the remote site's table of materials; by default any."""
    max_age_s: float = Field(default=limits.AGE_DEFAULT_S, gt=0.0, le=limits.AGE_MAX_S)
    gap_s: float = Field(default=limits.GAP_S, gt=0.0, le=limits.GAP_S)
    deadband: bool = True
    """Omit motion packets whose change would not be perceived."""


class ObserverConfig(StrictModel):
    """Configuration of a read-only client."""

    link: OperatorLinkConfig


RoomName = Annotated[str, Field(pattern=r"^[a-z0-9-]{1,32}$")]
"""Name of a room of a rendezvous: lower-case letters, digits and hyphens."""


class RendezvousConfig(StrictModel):
    """A rendezvous, at which two sites meet that cannot connect to each other. It carries encrypted bytes only."""

    bind: str = "127.0.0.1"
    port: int = Field(default=5640, ge=1, le=65535)
    rooms: dict[RoomName, Path] = Field(min_length=1)
    """File with the secret of each room; a room is for the two sites of one link."""
    status: Path | None = None
    log: LogForm = "text"


class TunnelConfig(StrictModel):
    """One site's end of a tunnel over a rendezvous."""

    side: Literal["remote", "operator"]
    host: str
    """Host of the rendezvous."""
    port: int = Field(default=5640, ge=1, le=65535)
    room: RoomName
    secret: Path
    """File with the room's secret."""
    site_host: str = "127.0.0.1"
    """Address of the site: the remote site is reached there, the operator site connects there."""
    base_port: int = Field(default=5600, ge=1, le=65529)
    """First port of the link at that address."""
    status: Path | None = None
    log: LogForm = "text"
