"""Run the operator site's simulated devices in one process: the hand in the exoskeleton, and its TactTips."""

from collections.abc import Callable
from contextlib import ExitStack, closing

import numpy as np

from common.buses.serial_messages import DRIVE_FULL
from common.config.file import to_toml
from common.config.simulation_models import SimOperatorConfig
from common.fingers import FINGERS
from common.scenes.scene import load_scene
from sim_sensors.devices.breakable_parts import Encoder, Hang, Thermistor, read_all
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.tacttip import TactTip, ntc_counts
from sim_sensors.faults.fault_port import FaultPort
from sim_sensors.faults.faults import Faults
from sim_sensors.faults.kinds import device_faults, operator_faults
from sim_sensors.operator_hand.hand import ScriptedHand
from sim_sensors.physics.finger_plate import FingerPlates
from sim_sensors.physics.motor import VibrationMotors
from sim_sensors.ports.intruder import Intruder
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.simulation_loop import STEP_S, run_world
from sim_sensors.serving import Serving, SocketServing, announce, serve_fingers
from sim_sensors.truth_log import LOG_EVERY, OPERATOR_STREAMS, TruthLog

_MEASURE_S = 0.010
"""Time between two readings of the NTCs, s."""
_INTRUDED = {"enabled": 1.0, **dict.fromkeys(FINGERS, 5.0)}
"""Forces that a second sender on the bus commands, N, and their enabling."""


class OperatorDevices:
    """Devices and physics of the operator's side.

    The hand starts its script once the exoskeleton has been driven for `DRIVEN_S`, and ends
    `config.seconds` later.

    Attributes:
        step_s: time that a step advances, s; at most 10 ms.
    """

    def __init__(self, config: SimOperatorConfig, sockets: SelectLoop, serving: Serving | None = None) -> None:
        """Open everything.

        Args:
            config: the devices and their addresses.
            sockets: event loop of the fault port, and by default of the devices.
            serving: server of the devices.

        Raises:
            ValueError: unknown scene, an address that is taken or malformed, a recording that cannot be written.
        """
        self.hand = ScriptedHand(load_scene(config.scene), seed=config.seed, fingers=config.fingers)
        self.exoskeleton = Exoskeleton()
        self.motors = VibrationMotors(len(FINGERS))
        self.plates = FingerPlates(len(FINGERS), config.seed)
        self.step_s = STEP_S
        serving = SocketServing(sockets) if serving is None else serving
        start_s = serving.now()
        self.modules = {finger: TactTip(FINGERS.index(finger), start_s) for finger in config.fingers}
        self.thermistors = {finger: Thermistor() for finger in config.fingers}
        self.encoders = {finger: Encoder(FINGERS.index(finger)) for finger in config.fingers}
        self.hang = Hang()
        self._seconds = config.seconds
        self._started_s: float | None = None
        self._steps = 0
        self._encoder_row = [(FINGERS.index(finger), part) for finger, part in self.encoders.items()]
        self._volts_now, self._permille = [0.0] * len(FINGERS), [0] * len(FINGERS)
        self._volts = np.zeros(len(FINGERS))
        self._drive = np.zeros(len(FINGERS))
        self._measure()
        with ExitStack() as opened:
            self.servers = serve_fingers(self.modules, serving, config.tacttip, "tacttip", opened)
            self.bus = opened.enter_context(closing(serving.bus(config.can_host, config.can_port, [self.exoskeleton])))
            self.faults = self._faults()
            if config.fault_port is not None:
                opened.enter_context(closing(FaultPort(sockets, config.fault_port, self.faults.apply)))
            log = TruthLog(config.record, OPERATOR_STREAMS, {"configuration": to_toml(config)})
            self._log = opened.enter_context(closing(log))
            self._opened = opened.pop_all()

    def step(self, now_s: float) -> None:
        """Advance the physics by one step to `now_s`, and send the reports that are due."""
        self.hang.pause()
        self._steps += 1
        self._work(now_s)
        force_n = self.exoskeleton.force_n(now_s)
        self.hand.step(self.step_s, force_n)
        self._measure_hand()
        self.bus.pump(now_s)
        volts, permille = [0.0] * len(FINGERS), [0] * len(FINGERS)
        for finger, module in self.modules.items():
            index = module.identity.finger
            volts[index] = module.motor_v(now_s - self.step_s, now_s)
            permille[index] = module.drive_permille
            self.servers[finger].pump(now_s)
            if module.motor_switched:
                for moment_s, motor_mv in module.take_motor_switches():
                    self._log.write("truth_motor", moment_s, {"finger": index, "motor_mv": motor_mv})
        if volts != self._volts_now:
            self._volts_now, self._volts = volts, np.array(volts)
        if permille != self._permille:
            self._permille, self._drive = permille, np.array(permille) / DRIVE_FULL
        self.motors.step(self.step_s, self._volts)
        self.plates.step(self.step_s, self._drive)
        if self._steps % round(_MEASURE_S / self.step_s) == 0:
            self._measure()
        if self._steps % LOG_EVERY == 0 and self._log.open:
            self._write_truth(now_s, force_n.tolist())

    def figures(self) -> dict[str, object]:
        """Return the content of the status file: the hand's progress, refused commands, faults, and the recording."""
        return {
            "scene_seconds": self.hand.total_seconds(),
            "script_s": self.hand.script_s,
            "finished": self.hand.finished,
            "can_clients": self.bus.clients,
            "frames_refused": self.exoskeleton.refused,
            "commands_refused": {finger: module.refused for finger, module in self.modules.items()},
            "frames_damaged": {finger: module.reader.damaged for finger, module in self.modules.items()},
            "faults": self.faults.in_force,
            **self._log.figures(),
        }

    def close(self) -> None:
        """Release all addresses and finish the recording."""
        self._opened.close()

    def _faults(self) -> Faults:
        self.bus.intruder = Intruder({"FingerForces": _INTRUDED})
        return Faults(
            {
                **device_faults(
                    {f"{finger} tacttip": server for finger, server in self.servers.items()},
                    self.bus,
                    self.exoskeleton,
                    drives=self.modules,
                    thermistors=self.thermistors,
                    contacts=self.plates.contacts,
                    encoders=self.encoders,
                    intruder=self.bus.intruder,
                    hang=self.hang,
                ),
                **operator_faults(self.exoskeleton, self.modules, self.plates),
            }
        )

    def _work(self, now_s: float) -> None:
        if self._started_s is None:
            if self.exoskeleton.driven(now_s):
                self._started_s = now_s
                self.hand.start()
        elif self._seconds is not None and now_s - self._started_s >= self._seconds:
            self.hand.finish()

    def _measure_hand(self) -> None:
        z_m = self.hand.heights_m.copy()
        read_all(self._encoder_row, z_m)
        self.exoskeleton.measure(self.hand.x_m, self.hand.y_m, z_m)

    def _measure(self) -> None:
        plate_c, hot_side_c = self.plates.ntc_c.tolist(), self.plates.hot_side_c.tolist()
        for finger, module in self.modules.items():
            index = module.identity.finger
            plate_counts = self.thermistors[finger].read(ntc_counts(plate_c[index]))
            module.measure(plate_counts, ntc_counts(hot_side_c[index]))

    def _write_truth(self, now_s: float, force_n: list[float]) -> None:
        hand, plates = self.hand, self.plates
        self._log.write(
            "truth_fingertips",
            now_s,
            {
                "motor_rpm": self.motors.rpm.tolist(),
                "motor_mv": [round(volts * 1e3) for volts in self._volts_now],
                "plate_c": plates.plate_c.tolist(),
                "hot_side_c": plates.hot_side_c.tolist(),
                "peltier": self._drive.tolist(),
                "surface_c": plates.surface_c.tolist(),
                "felt_c": plates.felt_c.tolist(),
                "force_n": force_n,
                "z_m": hand.heights_m,
                "x_m": hand.x_m,
                "y_m": hand.y_m,
                "script_mode": hand.mode,
                "act": hand.segment.act,
                "object": hand.segment.object,
            },
        )


def run_sim_operator(config: SimOperatorConfig, stop: Callable[[], bool]) -> None:
    """Serve the operator site's simulated devices until `stop()`.

    Raises:
        ValueError: the scene, an address or the recording of the configuration is unusable.
    """
    sockets = SelectLoop()
    with closing(OperatorDevices(config, sockets)) as devices:
        announce({f"tacttip {finger}": server.address for finger, server in devices.servers.items()})
        run_world(devices, sockets, stop, "sim-operator", config.status)
