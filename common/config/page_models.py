"""Processes that serve a web page: the operator's console, and the patient's page."""

from pathlib import Path

from pydantic import Field, model_validator

from common.config.recording_models import ConsentConfig, RecordingConfig, require_own_file
from common.files.strict_model import StrictModel
from common.link.keys import KEY_LENGTH
from common.logs import LogForm


class WebConfig(StrictModel):
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


class _ConsoleStreamConfig(StrictModel):
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
        require_own_file(self.record, self.status)
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
