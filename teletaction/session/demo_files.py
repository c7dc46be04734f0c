"""Prepares the files of one session on this machine: keys, and a configuration of each process."""

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from common.buses.can_address import CanAddress
from common.config.file import to_toml
from common.config.fingers import Addresses
from common.config.link_models import OperatorLinkConfig, RemoteLinkConfig
from common.config.page_models import ConsoleCameraConfig, ConsoleConfig, ConsoleVoiceConfig
from common.config.recording_models import ConsentConfig
from common.config.simulation_models import (
    SimCameraConfig,
    SimNetworkConfig,
    SimOperatorConfig,
    SimPatientSwitchConfig,
    SimRemoteConfig,
)
from common.config.site_models import CalibrationConfig, OperatorConfig, RemoteConfig
from common.config.stream_models import CameraConfig, VoiceConfig
from common.fingers import FingerName, chosen_fingers
from common.link.keys import TrustedKeys, create_keys
from common.scenes.scene import load_scene
from common.wire.noted_consent import KINDS
from sim_sensors.network.file import is_file, load_network
from teletaction.session.demo_ports import HOST, DemoPorts
from teletaction.session.session_rates import DEFAULT, Rates

SIMULATORS = ("sim-remote", "sim-operator")
"""Names of the processes that simulate devices."""
SITES = ("remote", "operator")
"""Names of the processes of both sites."""
PROCESSES = (*SIMULATORS, *SITES)
"""Names of the processes of every session."""
CONSOLE = "console"
"""Name of the further process of a session that a person runs in a browser."""
CAMERA = "camera"
"""Name of the further process of a session with a camera."""
VOICE = "voice"
"""Name of the further process of a session with a voice."""
NETWORK = "network"
"""Name of the further process of a session with a simulated network between the sites."""
WATCHED_S = 3.0
"""Time without a visible console page after which a session with a console pauses, s."""
REACTION_S = 0.6
"""Reaction time of the simulated patient of a scene with tender places, s."""
TENDER_CONSENT = ("touch", "pain")
"""What the made-up patient of such a scene agrees to have recorded."""
TABLES = Path(str(resources.files("remote_site"))) / "tables"
"""Folder of the shipped calibration tables."""
SURFACES = TABLES / "surfaces.json"
"""Shipped surface table, calibrated on simulated strokes."""


@dataclass(frozen=True, slots=True)
class DemoOptions:
    """Options of a session on this machine. If `seconds` is None, it runs until it is stopped."""

    seconds: float | None = 60.0
    scene: str = "materials"
    seed: int = 0
    fingers: int = 5
    network: str | None = None
    """Name or file of the network between the sites; None: they are connected directly."""
    out: Path | None = None
    console: bool = False
    """True if a person runs the session at the console; otherwise it engages by itself."""
    camera: bool = False
    """Whether the console shows a simulated camera at the remote site."""
    voice: bool = False
    """Whether the console hears a tone from the remote site."""
    consent: tuple[str, ...] | None = None
    """What the made-up patient agrees to have recorded, of KINDS; None: nobody has asked, but in a tender scene."""
    rates: Rates = DEFAULT
    patient_switch: bool = True
    """Whether the patient has a stop switch."""
    patient_stop_s: float | None = None
    """Time at which the patient presses it, s, from the first movement of the remote hand; None: never."""


def calibrated_tables(scene: str) -> tuple[Path, Path]:
    """Return the material and surface tables shipped for a scene.

    Raises:
        ValueError: no table was calibrated for this scene's materials.
    """
    loaded = load_scene(scene)
    blocks = "_blocks" if loaded.pieces == "calibrated" else ""
    materials = TABLES / f"{loaded.table or Path(scene).stem}{blocks}.json"
    if not materials.is_file():
        raise ValueError(f"scene {scene!r}: no calibrated table {materials.name}; make one with `calibrate thermal`")
    return materials, SURFACES


def prepare(options: DemoOptions, out: Path) -> dict[str, Path]:
    """Write keys and configurations of a session into `out`; return each process's configuration file.

    Raises:
        ValueError: invalid number of fingers or time, no calibration for the scene, unknown network or invalid network
            file, or a camera or voice that nothing shows, plays or reads.
    """
    _check(options)
    out = out.resolve()  # Relative paths would count from the configuration's folder.
    models = _Configurations(options, out).all()
    folder = out / "config"
    folder.mkdir(parents=True, exist_ok=True)
    _exchange_keys(out)
    configurations = {}
    for process, model in models.items():
        configurations[process] = folder / f"{process}.toml"
        configurations[process].write_text(to_toml(model), "utf-8")
    return configurations


def _check(options: DemoOptions) -> None:
    """Refuse times that are no times, and a camera or voice that nothing shows, plays or reads."""
    if options.seconds is not None and not 0.0 < options.seconds < math.inf:
        raise ValueError(f"--seconds {options.seconds:g}: must be a time above 0 s")
    if options.patient_stop_s is not None and not 0.0 <= options.patient_stop_s < math.inf:
        raise ValueError(f"--patient-stop {options.patient_stop_s:g}: must be a time of 0 s or more")
    for option, wanted in (("camera", options.camera), ("voice", options.voice)):
        if wanted and not options.console:
            raise ValueError(f"--{option}: only the console has it; leave out --headless or --{option}")
        if wanted and find_spec("av") is None:
            raise ValueError(f"--{option}: needs `pip install teletaction[{option}]`")


def _keys(out: Path, side: str) -> Path:
    return out / "keys" / side


def _exchange_keys(out: Path) -> None:
    """Create new keys of both sites, and let each trust the other's."""
    remote, operator = _keys(out, "remote"), _keys(out, "operator")
    for keys in (remote, operator):
        for old in ("site.key", "site.key_secret", "trusted"):
            (keys / old).unlink(missing_ok=True)
    TrustedKeys(remote).trust("operator", create_keys(operator))
    TrustedKeys(operator).trust("remote", create_keys(remote))


def _consent(options: DemoOptions) -> ConsentConfig | None:
    """Return the made-up patient's answer for the files of all processes that record; None where nobody has asked.

    Raises:
        ValueError: there is no such kind, or touch is missing, which each demo records.
    """
    agreed = options.consent
    if agreed is None and options.patient_switch and load_scene(options.scene).tender:
        agreed = TENDER_CONSENT
    if agreed is None:
        return None
    if unknown := sorted(set(agreed) - set(KINDS)):
        raise ValueError(f"--consent: {unknown[0]!r} is none of {', '.join(KINDS)}")
    if "touch" not in agreed:
        raise ValueError("--consent: a demo records touch; add touch")
    return ConsentConfig(**{kind: kind in agreed for kind in KINDS})


def _listening(ports: Mapping[FingerName, int]) -> Addresses:
    """Return the address of each simulated device, by finger."""
    return {finger: f"tcp:{HOST}:{port}" for finger, port in ports.items()}


def _reaching(ports: Mapping[FingerName, int]) -> Addresses:
    """Return the address at which a site reaches each device, by finger."""
    return {finger: f"socket://{HOST}:{port}" for finger, port in ports.items()}


def _can(port: int) -> CanAddress:
    return CanAddress(interface="socketcand", host=HOST, port=port)


class _Configurations:
    """Configuration of each process of a session, one method each."""

    def __init__(self, options: DemoOptions, out: Path) -> None:
        """Find the tables and the ports.

        Args:
            options: options, which `_check` has accepted.
            out: folder of the session, absolute.

        Raises:
            ValueError: invalid number of fingers or consent, or no calibration for the scene.
        """
        self._options, self._out = options, out
        self._fingers = chosen_fingers(options.fingers)
        self._materials, self._surfaces = calibrated_tables(options.scene)
        self._consent = _consent(options)
        self._ports = DemoPorts.free(self._fingers)

    def all(self) -> dict[str, BaseModel]:
        """Return the configurations, by process, in the order in which the processes start.

        Raises:
            ValueError: the network is unknown or its file is invalid.
        """
        options = self._options
        found: dict[str, BaseModel] = {"sim-remote": self._sim_remote(), "sim-operator": self._sim_operator()}
        if options.network is not None:
            found[NETWORK] = self._network(options.network)
        found |= {"remote": self._remote(), "operator": self._operator()}
        if options.camera:
            found[CAMERA] = self._camera()
        if options.voice:
            found[VOICE] = self._voice()
        if options.console:
            found[CONSOLE] = self._console()
        return found

    def _simulation(self, process: str) -> dict[str, Any]:
        """Return what both simulators have alike."""
        options = self._options
        # A relative path would count from the folder in which a process is started.
        scene = str(Path(options.scene).resolve()) if options.scene.endswith(".toml") else options.scene
        alike = {"fingers": self._fingers, "scene": scene, "seed": options.seed, "can_host": HOST}
        return alike | {"record": self._recording(process), "status": self._status(process)}

    def _site(self, process: str) -> dict[str, Any]:
        """Return what both sites have alike."""
        alike = {"fingers": self._fingers, "wait_for_devices_s": 20.0, "consent": self._consent}
        return alike | {"record": self._recording(process), "status": self._status(process)}

    def _recording(self, process: str) -> Path:
        return self._out / f"{process}.mcap"

    def _status(self, process: str) -> Path:
        return self._out / f"{process}.json"

    def _config(self, process: str) -> Path:
        return self._out / "config" / f"{process}.toml"

    def _sim_remote(self) -> SimRemoteConfig:
        ports, options = self._ports, self._options
        fields = self._simulation("sim-remote")
        if options.patient_switch:
            fields["patient_switch"] = self._sim_patient_switch()
        if options.camera:
            fields["camera"] = SimCameraConfig(port=f"tcp:{HOST}:{ports.camera}")
        return SimRemoteConfig(
            **fields,
            can_port=ports.robot,
            fault_port=ports.remote_faults,
            texture=_listening(ports.texture),
            thermal_sensors=_listening(ports.thermal),
        )

    def _sim_patient_switch(self) -> SimPatientSwitchConfig:
        """Return the patient's stop switch, with a slider where the scene is tender."""
        options = self._options
        presses_s = () if options.patient_stop_s is None else (options.patient_stop_s,)
        slider = {"reaction_s": REACTION_S} if load_scene(options.scene).tender else {}
        return SimPatientSwitchConfig(port=f"tcp:{HOST}:{self._ports.patient_switch}", pressed_at_s=presses_s, **slider)

    def _sim_operator(self) -> SimOperatorConfig:
        ports = self._ports
        return SimOperatorConfig(
            **self._simulation("sim-operator"),
            can_port=ports.exoskeleton,
            fault_port=ports.operator_faults,
            tacttip=_listening(ports.tacttip),
            seconds=self._options.seconds,
        )

    def _network(self, name_or_path: str) -> SimNetworkConfig:
        ports = self._ports
        load_network(name_or_path)  # so that a mistake is found before the process starts
        return SimNetworkConfig(
            network=str(Path(name_or_path).resolve()) if is_file(name_or_path) else name_or_path,
            bind=HOST,
            base_port=ports.through,
            to_host=HOST,
            to_base_port=ports.link,
            wait_for_start=True,
            seed=self._options.seed,
            fault_port=ports.network_faults,
            status=self._status(NETWORK),
        )

    def _remote(self) -> RemoteConfig:
        ports = self._ports
        fields = self._site("remote")
        if self._options.patient_switch:
            fields["patient_switch"] = {"port": f"socket://{HOST}:{ports.patient_switch}"}
        return RemoteConfig(
            **fields,
            rate_hz=self._options.rates.remote_hz,
            link=self._remote_link,
            texture=_reaching(ports.texture),
            thermal_sensors=_reaching(ports.thermal),
            telemanipulator=_can(ports.robot),
            desk_port=ports.remote_desk,
            calibration=CalibrationConfig(materials=self._materials, surfaces=self._surfaces),
        )

    @property
    def _remote_link(self) -> RemoteLinkConfig:
        return RemoteLinkConfig(bind=HOST, base_port=self._ports.link, keys=_keys(self._out, "remote"))

    def _operator(self) -> OperatorConfig:
        ports, console = self._ports, self._options.console
        return OperatorConfig(
            **self._site("operator"),
            rate_hz=self._options.rates.operator_hz,
            link=OperatorLinkConfig(host=HOST, base_port=self._far_port, keys=_keys(self._out, "operator")),
            tacttip=_reaching(ports.tacttip),
            exoskeleton=_can(ports.exoskeleton),
            engage=not console,
            console_required_s=WATCHED_S if console else 0.0,
            desk_port=ports.operator_desk,
            feed_port=ports.feed,
        )

    @property
    def _far_port(self) -> int:
        """First port at which the operator site reaches the streams of the remote site."""
        return self._ports.link if self._options.network is None else self._ports.through

    def _camera(self) -> CameraConfig:
        source = f"tcp://{HOST}:{self._ports.camera}"
        return CameraConfig(link=self._remote_link, source=source, status=self._status(CAMERA))

    def _voice(self) -> VoiceConfig:
        return VoiceConfig(
            link=self._remote_link,
            source="tone:440",
            sink="none",
            desk_port=self._ports.voice_desk,
            remote=self._config("remote"),
            status=self._status(VOICE),
        )

    def _console(self) -> ConsoleConfig:
        ports, options, consent = self._ports, self._options, self._consent
        far: dict[str, Any] = {"host": HOST, "base_port": self._far_port}
        camera = ConsoleCameraConfig(**far, record=consent is not None and consent.picture) if options.camera else None
        voice = ConsoleVoiceConfig(**far, record=consent is not None and consent.voice) if options.voice else None
        return ConsoleConfig(
            camera=camera,
            voice=voice,
            consent=consent,
            keys=_keys(self._out, "operator"),
            desk_port=ports.operator_desk,
            feed_port=ports.feed,
            port=ports.page,
            operator=self._config("operator"),
            record=self._recording(CONSOLE),
            reports=self._out / "reports",
            report_command=(
                *(sys.executable, "-m", "teletaction", "report"),
                *(str(self._recording(process)) for process in ("operator", "remote")),
                *("{record}", "--out", "{report}"),
            ),
            status=self._status(CONSOLE),
        )
