"""Run the remote site's simulated devices in one process: robot hand, its sensors, and the world they touch."""

from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import asdict

import numpy as np

from common.config.file import to_toml
from common.config.simulation_models import SimRemoteConfig
from common.fingers import FINGER_Y_M, FINGERS
from common.scenes.scene import load_scene
from sim_sensors.devices.breakable_parts import Encoder, ForceSensor, Hang, Piezo, Servos, Thermistor, read_all
from sim_sensors.devices.patient_switch import PatientSwitch
from sim_sensors.devices.scripted_patient import ScriptedPatient
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from sim_sensors.faults.fault_port import FaultPort
from sim_sensors.faults.faults import Faults
from sim_sensors.faults.kinds import device_faults, remote_faults
from sim_sensors.physics.camera_view import CameraView
from sim_sensors.physics.remote_world import RemoteWorld
from sim_sensors.ports.camera_server import CameraServer
from sim_sensors.ports.intruder import Intruder
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.simulation_loop import STEP_S, run_world
from sim_sensors.serving import Serving, SocketServing, announce, serve_fingers
from sim_sensors.truth_log import LOG_EVERY, REMOTE_STREAMS, TruthLog

_MEASURE_S = 0.010
"""Time between two readings of the thermometers, s."""
_FEEL_EVERY = 10
"""Steps between two forces that the simulated patient feels."""
_INTRUDED_HAND = {"x": 0.0, "y": 0.0}
"""Hand position that a second sender on the bus commands, mm."""
_INTRUDED_HEIGHTS = {"released": 0.0, **dict.fromkeys(FINGERS, 6.0)}
"""Heights that a second sender on the bus commands, mm, without a release."""


class RemoteDevices:
    """Devices and world of the remote side.

    Attributes:
        step_s: time that a step advances, s; at most 10 ms.
    """

    def __init__(self, config: SimRemoteConfig, sockets: SelectLoop, serving: Serving | None = None) -> None:
        """Open everything.

        Args:
            config: the devices and their addresses.
            sockets: event loop of the fault port, and by default of the devices.
            serving: server of the devices.

        Raises:
            ValueError: unknown scene, an address that is taken or malformed, a recording that cannot be written.
        """
        scene = load_scene(config.scene)
        self.world = RemoteWorld(scene, config.seed, config.fingers)
        self.robot = Telemanipulator()
        self.step_s = STEP_S
        serving = SocketServing(sockets) if serving is None else serving
        start_s = serving.now()
        self._indices = {finger: FINGERS.index(finger) for finger in config.fingers}
        self.texture = {finger: TextureSensor(index, start_s) for finger, index in self._indices.items()}
        self.piezos = {finger: Piezo(index) for finger, index in self._indices.items()}
        self.thermal = {finger: ThermalSensor(index, start_s) for finger, index in self._indices.items()}
        self.thermistors = {finger: Thermistor() for finger in config.fingers}
        self.encoders = {finger: Encoder(index) for finger, index in self._indices.items()}
        self.force_sensors = {finger: ForceSensor() for finger in config.fingers}
        switch = config.patient_switch
        self.patient_switch = None if switch is None else PatientSwitch(start_s)
        self._presses_s = [] if switch is None else sorted(switch.pressed_at_s)
        reaction_s = None if switch is None else switch.reaction_s
        self._patient = None if reaction_s is None else ScriptedPatient(scene.tender, reaction_s)
        self._driven_s: float | None = None
        self.servos = Servos()
        self.hang = Hang()
        self._permille: list[int] = []
        self._drive = np.zeros(len(FINGERS))
        self._encoder_row = [(self._indices[finger], part) for finger, part in self.encoders.items()]
        self._force_row = [(self._indices[finger], part) for finger, part in self.force_sensors.items()]
        self._steps = 0
        self._measure_robot()
        self._measure_plates()
        with ExitStack() as opened:
            self.texture_servers = serve_fingers(self.texture, serving, config.texture, "texture", opened)
            self.thermal_servers = serve_fingers(
                self.thermal, serving, config.thermal_sensors, "thermal_sensors", opened
            )
            self.patient_switch_server = None
            if switch is not None and self.patient_switch is not None:
                server = serving.line(self.patient_switch, switch.port, "patient_switch")
                self.patient_switch_server = opened.enter_context(closing(server))
            self.camera: CameraServer | None = None
            if config.camera is not None:
                self._view = CameraView(scene, config.fingers, config.camera.width, config.camera.height)
                self.camera = CameraServer(config.camera, sockets, self._draw, start_s)
                opened.enter_context(closing(self.camera))
            self.bus = opened.enter_context(closing(serving.bus(config.can_host, config.can_port, [self.robot])))
            self.faults = self._faults()
            if config.fault_port is not None:
                opened.enter_context(closing(FaultPort(sockets, config.fault_port, self.faults.apply)))
            self._log = opened.enter_context(
                closing(TruthLog(config.record, REMOTE_STREAMS, {"configuration": to_toml(config)}))
            )
            self._opened = opened.pop_all()
        self._servers = [*self.texture_servers.values(), *self.thermal_servers.values()]
        if self.patient_switch_server is not None:
            self._servers.append(self.patient_switch_server)

    def step(self, now_s: float) -> None:
        """Advance the world by one step to `now_s`, and send the reports that are due."""
        self.hang.pause()
        self._steps += 1
        permille = [module.drive_permille for module in self.thermal.values()]
        if permille != self._permille:
            self._permille = permille
            for module in self.thermal.values():
                self._drive[module.identity.finger] = module.drive
        world = self.world
        world.step(self.step_s, *self.servos.setpoint_m(now_s, self.robot.setpoint_m(now_s)), self._drive)
        self._measure_robot()
        self.bus.pump(now_s)
        counts = world.take_texture_counts()
        if counts.size:
            for finger, sensor in self.texture.items():
                sensor.add_samples(self.piezos[finger].read(counts[sensor.identity.finger]))
        if self._steps % round(_MEASURE_S / self.step_s) == 0:
            self._measure_plates()
        if self._presses_s:
            self._press_switch(now_s)
        if self._patient is not None and self.patient_switch is not None and self._steps % _FEEL_EVERY == 0:
            moved_x_m, moved_y_m, _ = world.shift_m
            places_y_m = [world.y_m + beside_m - moved_y_m for beside_m in FINGER_Y_M]
            self._patient.step(now_s, world.x_m - moved_x_m, places_y_m, world.forces_n)
            self.patient_switch.pain = self._patient.pain
        for server in self._servers:
            server.pump(now_s)
        if self.camera is not None:
            self.camera.pump(now_s)
        self._write_truth(now_s)

    def figures(self) -> dict[str, object]:
        """Return the content of the status file: CAN clients, refused commands, faults, and the recording."""
        return {
            "can_clients": self.bus.clients,
            "frames_refused": self.robot.refused,
            "commands_refused": {finger: module.refused for finger, module in self.thermal.items()},
            "frames_damaged": {finger: module.reader.damaged for finger, module in self.thermal.items()},
            "faults": self.faults.in_force,
            **self._log.figures(),
        }

    def close(self) -> None:
        """Release all addresses and finish the recording."""
        self._opened.close()

    def _faults(self) -> Faults:
        texture = {f"{finger} texture": server for finger, server in self.texture_servers.items()}
        thermal = {f"{finger} thermal": server for finger, server in self.thermal_servers.items()}
        switch = {} if self.patient_switch_server is None else {"patient switch": self.patient_switch_server}
        self.bus.intruder = Intruder({"HandSetpoint": _INTRUDED_HAND, "HeightSetpoint": _INTRUDED_HEIGHTS})
        return Faults(
            {
                **device_faults(
                    {**texture, **thermal, **switch},
                    self.bus,
                    self.robot,
                    drives=self.thermal,
                    thermistors=self.thermistors,
                    contacts=self.world.thermistor_contacts,
                    encoders=self.encoders,
                    intruder=self.bus.intruder,
                    hang=self.hang,
                ),
                **remote_faults(
                    self.robot,
                    self.servos,
                    self.force_sensors,
                    self.piezos,
                    self.world,
                    self.patient_switch,
                    self.camera,
                ),
            }
        )

    def _draw(self, now_s: float) -> bytes:
        """Return what the camera sees at `now_s`, s."""
        world = self.world
        return self._view.draw(now_s, world.x_m, world.y_m, world.force_n)

    def _press_switch(self, now_s: float) -> None:
        """Press the patient's switch at the times of the configuration, from the hand's first movement."""
        assert self.patient_switch is not None
        if self._driven_s is None:
            if self.robot.released:
                return
            self._driven_s = now_s
        while self._presses_s and now_s - self._driven_s >= self._presses_s[0]:
            self._presses_s.pop(0)
            self.patient_switch.press(now_s)

    def _measure_robot(self) -> None:
        world = self.world
        z_m, force_n = world.heights_m.copy(), world.read_n.copy()
        read_all(self._encoder_row, z_m)
        read_all(self._force_row, force_n)
        self.robot.measure(world.x_m, world.y_m, z_m, force_n)

    def _measure_plates(self) -> None:
        plates, ambient = self.world.ssr_counts().tolist(), self.world.ambient_counts().tolist()
        for finger, module in self.thermal.items():
            index = module.identity.finger
            module.measure(self.thermistors[finger].read(plates[index]), ambient[index])

    def _write_truth(self, now_s: float) -> None:
        world = self.world
        for event in world.take_events():
            entry = asdict(event)
            self._log.write("truth_event", now_s + entry.pop("time_s") - world.time_s, entry)
        if self._steps % LOG_EVERY or not self._log.open:
            return
        self._log.write(
            "truth_contact",
            now_s,
            {
                "mode": world.mode.tolist(),
                "object": world.object_index.tolist(),
                "force_n": world.forces_n,
                "plate_c": world.plate_c.tolist(),
                "heater": self._drive.tolist(),
                "z_m": world.heights_m,
                "x_m": world.x_m,
                "y_m": world.y_m,
            },
        )


def run_sim_remote(config: SimRemoteConfig, stop: Callable[[], bool]) -> None:
    """Serve the remote site's simulated devices until `stop()`.

    Raises:
        ValueError: the scene, an address or the recording of the configuration is unusable.
    """
    sockets = SelectLoop()
    with closing(RemoteDevices(config, sockets)) as devices:
        announce({f"texture {finger}": server.address for finger, server in devices.texture_servers.items()})
        announce({f"thermal_sensors {finger}": server.address for finger, server in devices.thermal_servers.items()})
        if devices.patient_switch_server is not None:
            announce({"patient_switch": devices.patient_switch_server.address})
        if devices.camera is not None:
            announce({"camera": devices.camera.address})
        run_world(devices, sockets, stop, "sim-remote", config.status)
