"""Camera and voice of the remote site."""

from pathlib import Path
from typing import Annotated

from pydantic import BeforeValidator, Field

from common.config.link_models import RemoteLinkConfig
from common.files.strict_model import StrictModel
from common.logs import LogForm


class CameraConfig(StrictModel):
    """The camera's process at the remote site."""

    link: RemoteLinkConfig
    """The remote site's link: the camera listens on the port of the stream `camera`, with the same keys."""
    source: str = Field(min_length=1)
    """A video device such as `/dev/video0`, or an address such as `rtsp://host/stream` or `tcp://host:port`."""
    width: int = Field(default=640, ge=64, le=1920, multiple_of=8)
    height: int = Field(default=360, ge=64, le=1088, multiple_of=8)
    rate_hz: float = Field(default=15.0, ge=1.0, le=30.0)
    bit_s: int = Field(default=400_000, ge=20_000, le=10_000_000)
    """Bit rate of the best picture, bit/s."""
    delay_s: float = Field(default=0.0, ge=0.0, le=1.0)
    """Time from the exposure of a picture to its arrival from the camera, s."""
    status: Path | None = None
    log: LogForm = "text"


def _sound_file(given: object) -> object:
    """Return a text that names neither a tone nor a device as a path, so that it counts from the file's folder."""
    if not isinstance(given, str) or given == "none" or given.partition(":")[0] in ("tone", "alsa"):
        return given
    return Path(given)


SoundPlace = Annotated[Annotated[str, Field(min_length=1)] | Path, BeforeValidator(_sound_file)]
"""A device such as `alsa:default`, or a sound file."""


class VoiceConfig(StrictModel):
    """The voice's process at the remote site."""

    link: RemoteLinkConfig
    """The remote site's link: the voice listens on the port of the stream `voice`, with the same keys."""
    source: SoundPlace = "alsa:default"
    """The microphone: a device, a sound file that is repeated, or `tone:440`."""
    sink: SoundPlace = "alsa:default"
    """The loudspeaker: a device, a WAV file, or `none`."""
    desk_port: int = Field(default=5607, ge=1, le=65535)
    """Loopback port for commands of a person at this site (`teletaction session mute-voice`)."""
    remote: Path | None = None
    """The remote site's configuration, whose `[consent]` holds whether sound may be recorded; by default it may not."""
    status: Path | None = None
    log: LogForm = "text"
