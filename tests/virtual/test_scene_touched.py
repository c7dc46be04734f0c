"""A virtual environment on simulated devices and a virtual clock: the scripted hand feels what it touches."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from common.fingers import FINGERS
from common.limits import MOTOR_FLOOR_RPM
from common.scenes.scene import load_scene
from common.timing.standstill import HostClock
from operator_site.devices.devices import OperatorDevices
from operator_site.site import OperatorSite
from operator_site.virtual.virtual_environment import VirtualEnvironment
from operator_site.virtual.virtual_session import VirtualSession
from sim_sensors import operator_devices
from sim_sensors.ports.select_loop import SelectLoop
from teletaction.testbed.memory_wiring import MemoryWiring
from teletaction.testbed.site_clock import SiteClock
from tests.virtual import configurations
from tests.virtual.configurations import FINGER
from tests.virtual.session import TICK_S

_INDEX = FINGERS.index(FINGER)


class Touching:
    """The operator site on a scene, its devices, and the hand that follows the scene's script."""

    def __init__(self, scene: str):
        self.time_s = 0.0
        self.wiring = MemoryWiring(lambda: self.time_s)
        self.clock = SiteClock(100.456)
        simulated = configurations.sim_operator(0).model_copy(update={"scene": scene})
        self.simulated = operator_devices.OperatorDevices(simulated, SelectLoop(lambda: self.time_s), self.wiring)
        config = configurations.operator(0.15)
        environment = VirtualEnvironment(load_scene(scene), config.fingers, 0)
        self.client = VirtualSession(environment, scene, config.engage)
        devices = OperatorDevices(config, HostClock(lambda: self.clock.now_ns(self.time_s)), self.wiring)
        self.devices = devices
        self.site = OperatorSite(config, self.client, devices)

    def run(self, seconds: float) -> dict[str, np.ndarray]:
        """Let time pass; returns what was truly at the finger, and where it was."""
        found = []
        for _ in range(round(seconds / TICK_S)):
            self.time_s += TICK_S
            self.simulated.step(self.time_s)
            self.site.tick(self.clock.now_ns(self.time_s))
            hand, plates = self.simulated.hand, self.simulated.plates
            found.append(
                (
                    hand.segment.object,
                    hand.segment.act,
                    float(self.simulated.exoskeleton.force_n(self.time_s)[_INDEX]),
                    float(self.simulated.motors.rpm[_INDEX]),
                    float(plates.plate_c[_INDEX]),
                    float(plates.felt_c[_INDEX]),
                )
            )
        names = ("object", "act", "force_n", "rpm", "plate_c", "felt_c")
        return {name: np.array(values) for name, values in zip(names, zip(*found, strict=True), strict=True)}


@contextmanager
def touching(scene: str) -> Iterator[Touching]:
    session = Touching(scene)
    try:
        yield session
    finally:
        session.devices.close()
        session.simulated.close()


@pytest.mark.long
def test_force_and_vibration_of_the_textures_reach_the_finger() -> None:
    with touching("paper_textures") as session:
        truth = session.run(21.0)
        assert session.client.both_engaged
    strokes = truth["act"] == "stroke"
    rpm = {name: float(truth["rpm"][strokes & (truth["object"] == name)].mean()) for name in set(truth["object"])}
    assert rpm["foam"] < 0.1 * rpm["plain"]
    assert rpm["plain"] < rpm["widely_grooved"] < rpm["closely_grooved"]
    assert rpm["plain"] < rpm["sandpaper"]
    assert np.median(truth["rpm"][strokes & (truth["object"] == "plain")]) > 0.95 * MOTOR_FLOOR_RPM, "it is felt"
    assert np.median(truth["force_n"][strokes]) > 0.5
    assert not truth["force_n"][truth["act"] == "move"][50:].any()


@pytest.mark.long
def test_heat_of_the_materials_reaches_the_finger() -> None:
    with touching("paper_materials") as session:
        truth = session.run(23.0)
    held = {name: (truth["object"] == name) & (truth["act"] == "hold") for name in ("aluminium", "ceramic")}
    coldest = {name: float(truth["plate_c"][during].min()) for name, during in held.items()}
    last_c = {name: float(truth["felt_c"][during][-1]) for name, during in held.items()}
    for celsius in (coldest, last_c):
        assert celsius["aluminium"] < celsius["ceramic"]
    first = truth["felt_c"][held["aluminium"]]
    assert first[-1] < first[0] - 3.0


def test_nothing_is_displayed_without_the_positions_of_the_hand() -> None:
    with touching("paper_textures") as session:
        session.run(3.0)
        assert session.run(0.5)["force_n"].any()
        session.simulated.faults.apply("unplug can")
        session.run(0.2)
        truth = session.run(0.3)
        assert session.simulated.modules[FINGER].motor_mv == 0
        assert session.simulated.modules[FINGER].drive == 0.0
        assert not truth["force_n"].any()
