"""Configurations of a session in one process: addresses are the names of lines and buses in memory."""

from pathlib import Path

from common.buses.can_address import CanAddress
from common.config.link_models import OperatorLinkConfig, RemoteLinkConfig
from common.config.simulation_models import SimOperatorConfig, SimPatientSwitchConfig, SimRemoteConfig
from common.config.site_models import CalibrationConfig, OperatorConfig, PatientSwitchConfig, RemoteConfig
from common.fingers import FingerName
from teletaction.session.demo_files import SURFACES, TABLES, WATCHED_S

FINGER: FingerName = "index"
"""The one in use."""
TEXTURE, THERMAL, TACTTIP = (f"{kind}/{FINGER}" for kind in ("texture", "thermal", "tacttip"))
PATIENT_SWITCH = "patient_switch"
ROBOT, EXOSKELETON = 1, 2
"""Names of the buses: they stand where a CAN gateway has its port."""
_SCENE = str(Path(__file__).with_name("stroking.toml"))
_NO_KEYS = Path("keys")


def sim_remote(seed: int, pressed_at_s: tuple[float, ...] | None = None) -> SimRemoteConfig:
    """The simulated devices of the remote site; with times of presses, the patient has a stop switch."""
    return SimRemoteConfig(
        fingers=(FINGER,),
        scene=_SCENE,
        seed=seed,
        can_port=ROBOT,
        texture={FINGER: TEXTURE},
        thermal_sensors={FINGER: THERMAL},
        patient_switch=None
        if pressed_at_s is None
        else SimPatientSwitchConfig(port=PATIENT_SWITCH, pressed_at_s=pressed_at_s),
    )


def sim_operator(seed: int) -> SimOperatorConfig:
    """The simulated devices of the operator's site, and the hand."""
    return SimOperatorConfig(
        fingers=(FINGER,), scene=_SCENE, seed=seed, can_port=EXOSKELETON, tacttip={FINGER: TACTTIP}
    )


def remote(max_age_s: float, *, patient_switch: bool = False) -> RemoteConfig:
    """The remote site."""
    return RemoteConfig(
        fingers=(FINGER,),
        link=RemoteLinkConfig(keys=_NO_KEYS, max_age_s=max_age_s),
        texture={FINGER: TEXTURE},
        thermal_sensors={FINGER: THERMAL},
        telemanipulator=CanAddress(interface="socketcand", port=ROBOT),
        calibration=CalibrationConfig(materials=TABLES / "materials.json", surfaces=SURFACES),
        patient_switch=PatientSwitchConfig(port=PATIENT_SWITCH) if patient_switch else None,
    )


def operator(max_age_s: float, *, at_console: bool = False) -> OperatorConfig:
    """The operator's site, which engages as soon as it can; or when somebody at its console asks and watches."""
    return OperatorConfig(
        fingers=(FINGER,),
        link=OperatorLinkConfig(keys=_NO_KEYS, max_age_s=max_age_s),
        tacttip={FINGER: TACTTIP},
        exoskeleton=CanAddress(interface="socketcand", port=EXOSKELETON),
        engage=not at_console,
        console_required_s=WATCHED_S if at_console else 0.0,
    )
