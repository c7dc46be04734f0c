"""Prepares the files of one session on this machine: keys, resolved configurations, free ports."""

import math
import os
import socket
import sys
from contextlib import ExitStack
from dataclasses import dataclass
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from common.buses.can_address import CanAddress
from common.config.file import to_toml
from common.config.link_models import OperatorLinkConfig, RemoteLinkConfig
from common.config.page_models import ConsoleCameraConfig, ConsoleConfig, ConsoleVoiceConfig
from common.config.recording_models import ConsentConfig
from common.config.simulation_models import SimCameraConfig, SimNetworkConfig, SimOperatorConfig, SimRemoteConfig
from common.config.site_models import CalibrationConfig, OperatorConfig, RemoteConfig
from common.config.stream_models import CameraConfig, VoiceConfig
from common.fingers import chosen_fingers
from common.link.keys import TrustedKeys, create_keys
from common.scenes.scene import load_scene
from common.wire.noted_consent import KINDS
from common.wire.streams import STREAMS
from sim_sensors.network.file import is_file, load_network
from teletaction.session.session_rates import DEFAULT, Rates

HOST = "127.0.0.1"
PROCESSES = ("sim-remote", "sim-operator", "remote", "operator")
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


def free_port_block(count: int) -> int:
    """Return the first of `count` consecutive free ports, below the range of outgoing connections.

    Raises:
        OSError: no such block was found.
    """
    firsts = range(20_000, 32_000, count)
    # The start depends on the process, so that sessions prepared at the same time take different blocks.
    turn = os.getpid() % len(firsts)
    for number in range(len(firsts)):
        first = firsts[(turn + number) % len(firsts)]
        with ExitStack() as held:
            try:
                for n in range(count):
                    held.enter_context(socket.create_server((HOST, first + n)))
            except OSError:
                continue
            return first
    raise OSError(f"no {count} consecutive free ports on {HOST}")


def _network(name_or_path: str, base_port: int, **settings: object) -> SimNetworkConfig:
    """Return the configuration of the network.

    The network is loaded here so that a mistake is found before its process starts.

    Raises:
        ValueError: the network is unknown or its file is invalid.
    """
    load_network(name_or_path)
    network = str(Path(name_or_path).resolve()) if is_file(name_or_path) else name_or_path
    fields = {"network": network, "bind": HOST, "base_port": base_port, "to_host": HOST, "wait_for_start": True}
    return SimNetworkConfig.model_validate(fields | settings)


def _patient_switch(options: DemoOptions, port: int) -> tuple[dict[str, object], dict[str, object]]:
    """Return the fields of the patient's stop switch, with a slider where the scene is tender, of both processes."""
    if not options.patient_switch:
        return {}, {}
    remote: dict[str, object] = {"patient_switch": {"port": f"socket://{HOST}:{port}"}}
    presses_s = () if options.patient_stop_s is None else (options.patient_stop_s,)
    patient: dict[str, object] = {"port": f"tcp:{HOST}:{port}", "pressed_at_s": presses_s}
    if load_scene(options.scene).tender:
        patient["reaction_s"] = REACTION_S
    return remote, {"patient_switch": patient}


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


def _beside(
    options: DemoOptions, link: RemoteLinkConfig, source: str, *, desk_port: int, out: Path
) -> dict[str, BaseModel]:
    """Return the configurations of the processes beside the remote site: camera and voice."""
    models: dict[str, BaseModel] = {}
    remote = out / "config" / "remote.toml"
    if options.camera:
        models[CAMERA] = CameraConfig(link=link, source=source, status=out / f"{CAMERA}.json")
    if options.voice:
        models[VOICE] = VoiceConfig(
            link=link,
            source="tone:440",
            sink="none",
            desk_port=desk_port,
            remote=remote,
            status=out / f"{VOICE}.json",
        )
    return models


def prepare(options: DemoOptions, out: Path) -> dict[str, Path]:
    """Write keys and configurations of a session into `out`; return each process's configuration file.

    Raises:
        ValueError: invalid number of fingers or time, no calibration for the scene, unknown network or invalid network
            file, or a camera or voice that nothing shows, plays or reads.
    """
    if options.seconds is not None and not 0.0 < options.seconds < math.inf:
        raise ValueError(f"--seconds {options.seconds:g}: must be a time above 0 s")
    if options.patient_stop_s is not None and not 0.0 <= options.patient_stop_s < math.inf:
        raise ValueError(f"--patient-stop {options.patient_stop_s:g}: must be a time of 0 s or more")
    for option, wanted in (("camera", options.camera), ("voice", options.voice)):
        if wanted and not options.console:
            raise ValueError(f"--{option}: only the console has it; leave out --headless or --{option}")
        if wanted and find_spec("av") is None:
            raise ValueError(f"--{option}: needs `pip install teletaction[{option}]`")
    out = out.resolve()  # Relative paths would count from the configuration's folder.
    fingers = chosen_fingers(options.fingers)
    materials, surfaces = calibrated_tables(options.scene)
    folder = out / "config"
    folder.mkdir(parents=True, exist_ok=True)
    remote_keys, operator_keys = out / "keys" / "remote", out / "keys" / "operator"
    for keys in (remote_keys, operator_keys):
        for old in ("site.key", "site.key_secret", "trusted"):
            (keys / old).unlink(missing_ok=True)
    TrustedKeys(remote_keys).trust("operator", create_keys(operator_keys))
    TrustedKeys(operator_keys).trust("remote", create_keys(remote_keys))
    streams, others = 2 * len(STREAMS), 3 * len(fingers) + 12
    base_port = free_port_block(streams + others)
    ports = iter(range(base_port + streams, base_port + streams + others))
    texture, thermal, tacttip = ({finger: next(ports) for finger in fingers} for _ in range(3))
    robot_port, exoskeleton_port = next(ports), next(ports)

    def listening(serial: dict[str, int]) -> dict[str, str]:
        return {finger: f"tcp:{HOST}:{port}" for finger, port in serial.items()}

    def reaching(serial: dict[str, int]) -> dict[str, str]:
        return {finger: f"socket://{HOST}:{port}" for finger, port in serial.items()}

    def files(process: str) -> dict[str, Path]:
        return {"record": out / f"{process}.mcap", "status": out / f"{process}.json"}

    simulation = {"fingers": fingers, "scene": options.scene, "seed": options.seed, "can_host": HOST}
    consent = _consent(options)
    site = {"fingers": fingers, "wait_for_devices_s": 20.0, "consent": consent}
    remote_switch, sim_switch = _patient_switch(options, next(ports))
    operator_port, network = base_port, {}
    if options.network is not None:
        operator_port += len(STREAMS)
        network[NETWORK] = _network(
            options.network,
            operator_port,
            to_base_port=base_port,
            seed=options.seed,
            fault_port=next(ports),
            status=out / f"{NETWORK}.json",
        )
    camera_port = next(ports)
    sim_camera = {"camera": SimCameraConfig(port=f"tcp:{HOST}:{camera_port}")} if options.camera else {}
    remote_link = RemoteLinkConfig(bind=HOST, base_port=base_port, keys=remote_keys)
    models: dict[str, BaseModel] = {
        "sim-remote": SimRemoteConfig.model_validate(
            simulation
            | files("sim-remote")
            | {
                "can_port": robot_port,
                "fault_port": next(ports),
                "texture": listening(texture),
                "thermal_sensors": listening(thermal),
                **sim_switch,
                **sim_camera,
            }
        ),
        "sim-operator": SimOperatorConfig.model_validate(
            simulation
            | files("sim-operator")
            | {
                "can_port": exoskeleton_port,
                "fault_port": next(ports),
                "tacttip": listening(tacttip),
                "seconds": options.seconds,
            }
        ),
        **network,
        "remote": RemoteConfig.model_validate(
            site
            | files("remote")
            | {
                "rate_hz": options.rates.remote_hz,
                "link": remote_link,
                "texture": reaching(texture),
                "thermal_sensors": reaching(thermal),
                "telemanipulator": CanAddress(interface="socketcand", host=HOST, port=robot_port),
                "desk_port": next(ports),
                "calibration": CalibrationConfig(materials=materials, surfaces=surfaces),
                **remote_switch,
            }
        ),
        "operator": OperatorConfig.model_validate(
            site
            | files("operator")
            | {
                "rate_hz": options.rates.operator_hz,
                "link": OperatorLinkConfig(host=HOST, base_port=operator_port, keys=operator_keys),
                "tacttip": reaching(tacttip),
                "exoskeleton": CanAddress(interface="socketcand", host=HOST, port=exoskeleton_port),
                "engage": not options.console,
                "console_required_s": WATCHED_S if options.console else 0.0,
                "desk_port": (desk_port := next(ports)),
                "feed_port": (feed_port := next(ports)),
            }
        ),
    }
    source = f"tcp://{HOST}:{camera_port}"
    models |= _beside(options, remote_link, source, desk_port=next(ports), out=out)
    if options.console:
        far: dict[str, Any] = {"host": HOST, "base_port": operator_port}
        models[CONSOLE] = ConsoleConfig(
            camera=ConsoleCameraConfig(**far, record=consent is not None and consent.picture)
            if options.camera
            else None,
            voice=ConsoleVoiceConfig(**far, record=consent is not None and consent.voice) if options.voice else None,
            consent=consent,
            keys=operator_keys,
            desk_port=desk_port,
            feed_port=feed_port,
            port=next(ports),
            operator=folder / "operator.toml",
            record=out / f"{CONSOLE}.mcap",
            reports=out / "reports",
            report_command=(
                *(sys.executable, "-m", "teletaction", "report"),
                *(str(out / f"{process}.mcap") for process in ("operator", "remote")),
                *("{record}", "--out", "{report}"),
            ),
            status=out / f"{CONSOLE}.json",
        )
    configurations = {}
    for process, model in models.items():
        configurations[process] = folder / f"{process}.toml"
        configurations[process].write_text(to_toml(model), "utf-8")
    return configurations
