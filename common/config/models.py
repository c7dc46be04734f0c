"""Models of each process's configuration, with rules between fields."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from common import limits
from common.buses.can_address import CanAddress
from common.fingers import FINGERS
from common.link.keys import KEY_LENGTH
from common.logs import LogForm
from common.timing.timeouts import FASTEST_RATE_HZ, SLOWEST_RATE_HZ, check_ladder

FingerName = Literal["thumb", "index", "middle", "ring", "little"]


def _each_once(fingers: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(fingers)) < len(fingers):
        raise ValueError("a finger is named twice")
    return fingers


Fingers = Annotated[tuple[FingerName, ...], Field(min_length=1, max_length=5), AfterValidator(_each_once)]
Addresses = dict[FingerName, str]
"""Address of each finger's serial device: a tty path or `socket://host:port`."""


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class RemoteLinkConfig(_Section):
    """The remote site's side of the link. Curve keys are mandatory."""

    bind: str = "127.0.0.1"
    base_port: int = Field(default=5600, ge=1, le=65529)
    keys: Path
    max_age_s: float = Field(default=limits.AGE_DEFAULT_S, gt=0.0, le=limits.AGE_MAX_S)
    gap_s: float = Field(default=limits.GAP_S, gt=0.0, le=limits.GAP_S)
    deadband: bool = True
    """Omit touch packets whose change the operator would not perceive."""


class OperatorLinkConfig(_Section):
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


class ConsentConfig(_Section):
    """What the patient agrees to have recorded, asked before the session."""

    touch: bool
    pain: bool
    picture: bool = False
    voice: bool = False


class RecordingConfig(_Section):
    """How a process records."""

    encrypt: bool = False
    """Whether the recording is encrypted for the owner of the site's secret key."""


class SiteConfig(_Section):
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


class CalibrationConfig(_Section):
    """Calibrated look-up tables of the remote site, written by `teletaction calibrate`."""

    materials: Path
    surfaces: Path


class PatientConfig(_Section):
    """Limits of the patient side's gate, within `common.limits`."""

    contact_force_n: float = Field(default=limits.CONTACT_FORCE_N, gt=0.0, le=limits.CONTACT_FORCE_N)


class PatientSwitchConfig(_Section):
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


class CameraConfig(_Section):
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


class VoiceConfig(_Section):
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


VibrationScale = Literal["speed", "intensity"]
"""Quantity in which Eq. 1 and 2 are linear: motor speed, as in the paper, or perceived intensity."""


class RenderingConfig(_Section):
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


class _ConsoleStreamConfig(_Section):
    """A process of the remote site that serves the console beside the session."""

    host: str = "127.0.0.1"
    """Host of the remote site."""
    base_port: int = Field(default=5600, ge=1, le=65529)
    """First port of the remote site's link."""
    remote_key: str | None = Field(default=None, min_length=KEY_LENGTH, max_length=KEY_LENGTH)
    """Public key of the remote site; by default the key that the key folder trusts under the name `remote`."""


class ConsoleCameraConfig(_ConsoleStreamConfig):
    """The camera that the console shows."""

    required: bool = False
    """Whether the session pauses while the picture is late or frozen."""
    record: bool = False
    """Whether the console records the picture, which needs `consent.picture`."""


class ConsoleVoiceConfig(_ConsoleStreamConfig):
    """The voice between the console's pages and the remote site."""

    record: bool = False
    """Whether the console records the sound of both sides, which needs `consent.voice` here and at the
    remote site."""


class WebConfig(_Section):
    """A web page that a process serves."""

    bind: str = "127.0.0.1"
    port: int = Field(default=8090, ge=0, le=65535)
    """Port of the page; 0 selects a free one."""
    tokens: Path | None = None
    """File with lines `NAME act|observe TOKEN` of users who may open the page; without it, anybody on loopback may."""
    certificate: Path | None = None
    certificate_key: Path | None = None
    """Private key for TLS, PEM, as is `certificate`."""
    behind_proxy: bool = False
    """Whether a reverse proxy in front of the page serves TLS."""
    address: str | None = None
    """Address of the page in browsers where it differs from `bind`, such as `https://console.example`."""

    @model_validator(mode="after")
    def _whole_certificate(self) -> "WebConfig":
        if (self.certificate is None) != (self.certificate_key is None):
            raise ValueError("certificate and certificate_key go together")
        return self


class ConsoleConfig(WebConfig):
    """The console: a web page at the operator site, served by a separate process on the same machine."""

    keys: Path
    """Key folder of the operator site: a user who may read its secret key may run its console."""
    desk_port: int = Field(default=5609, ge=1, le=65535)
    feed_port: int = Field(default=5610, ge=1, le=65535)
    """The operator site's port for the console's data."""
    camera: ConsoleCameraConfig | None = None
    """The remote site's camera; by default there is none."""
    voice: ConsoleVoiceConfig | None = None
    """The voice of the remote site; by default there is none."""
    operator: Path | None = None
    """The operator site's configuration file, named in advice on the page."""
    record: Path | None = None
    """MCAP file of findings and actions; without it, no finding is kept."""
    recording: RecordingConfig = RecordingConfig()
    consent: ConsentConfig | None = None
    """The patient's answer, as the remote site has it; by default neither picture nor sound is recorded."""
    reports: Path | None = None
    """Folder of reports, served as `/report/NAME.html`."""
    report_command: tuple[str, ...] = ()
    """Command that writes the report of an ended examination. The output file replaces `{report}` in it; the
    recordings of the findings replace the word `{record}`."""
    status: Path | None = None
    log: LogForm = "text"

    @model_validator(mode="after")
    def _consents(self) -> "ConsoleConfig":
        for name, stream, what, agreed in (
            ("camera", self.camera, "pictures", self.consent and self.consent.picture),
            ("voice", self.voice, "sound", self.consent and self.consent.voice),
        ):
            if stream is not None and stream.record and not agreed:
                raise ValueError(
                    f"{name}.record is true, but no consent to {what} is noted: ask the patient and note the answer in "
                    f"[consent], or remove {name}.record"
                )
        return self


class PatientPageConfig(WebConfig):
    """The patient's stop switch and pain slider as a page, which the remote site reads as a serial device."""

    port: int = Field(default=8091, ge=0, le=65535)
    switch_port: int = Field(ge=0, le=65535)
    """Loopback port of the switch: 5611 for `port = "socket://127.0.0.1:5611"` in the site's `[patient_switch]`."""
    slider: bool = True
    """Whether the page has a pain slider."""
    status: Path | None = None
    log: LogForm = "text"


class ObserverConfig(_Section):
    """Configuration of a read-only client."""

    link: OperatorLinkConfig


RoomName = Annotated[str, Field(pattern=r"^[a-z0-9-]{1,32}$")]
"""Name of a room of a rendezvous: lower-case letters, digits and hyphens."""


class RendezvousConfig(_Section):
    """A rendezvous, at which two sites meet that cannot connect to each other. It carries encrypted bytes only."""

    bind: str = "127.0.0.1"
    port: int = Field(default=5640, ge=1, le=65535)
    rooms: dict[RoomName, Path] = Field(min_length=1)
    """File with the secret of each room; a room is for the two sites of one link."""
    status: Path | None = None
    log: LogForm = "text"


class TunnelConfig(_Section):
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


class _SimulationConfig(_Section):
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


class SimPatientSwitchConfig(_Section):
    """The simulated stop switch of the patient."""

    port: str
    """`pty`, or `tcp:HOST:PORT` to listen on."""
    pressed_at_s: tuple[float, ...] = ()
    """Times at which the patient presses it, s, from the first movement of the telemanipulator."""
    reaction_s: float | None = Field(default=None, gt=0.0, le=5.0)
    """Reaction time with which the patient moves the pain slider, s; by default there is no slider."""


class SimCameraConfig(_Section):
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


class SimNetworkConfig(_Section):
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
