"""The CAN drivers against their emulators over socketcand."""

import time
from collections.abc import Iterator

import numpy as np
import pytest

import sim_sensors.devices.can_node
from common.buses.can_address import CanAddress
from common.buses.serial_port import DeviceAbsent
from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from operator_site.devices.exoskeleton import Exoskeleton as ExoskeletonDriver
from remote_site.devices.telemanipulator import Telemanipulator as TelemanipulatorDriver
from sim_sensors.devices.can_node import CanNode
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.ports.intruder import Intruder
from tests.unit.devices.rigs import Rig, alone

Driver = ExoskeletonDriver | TelemanipulatorDriver


class Frames:
    """A line that brings the test's frames."""

    connected = drained = True
    fault = None

    def __init__(self) -> None:
        self.came: dict[str, list[tuple[float, tuple[float, ...]]]] = {}

    def poll(self) -> dict[str, list[tuple[float, tuple[float, ...]]]]:
        return self.came


@pytest.mark.parametrize("first", [20, 21])
@pytest.mark.parametrize(
    ("kind", "pose", "heights"),
    [
        (ExoskeletonDriver, "HandPose", "FingerHeights"),
        (TelemanipulatorDriver, "HandPoseMeasured", "FingerHeightsMeasured"),
    ],
)
def test_an_encoder_jumps_at_any_frame_of_a_tick(kind: type[Driver], pose: str, heights: str, first: int) -> None:
    """A site of 250 Hz reads two frames in each tick."""
    driver = kind(CanAddress(interface="virtual", channel=f"{pose}-{first}"))
    driver.line.close()
    line = Frames()
    driver.line = line  # type: ignore[assignment]
    found = set()
    for number in range(0, 60, 2):
        frames = [(0.002 * n, (8.0 * (n >= first),) * 5) for n in (number, number + 1)]
        line.came = {pose: [(sent_s, (0.0, 0.0)) for sent_s, _ in frames], heights: frames, "ContactForces": frames}
        driver.read(0.002 * number)
        found.update(fault.code for fault in driver.faults(0.002 * number))
    assert FaultCode.ENCODER_JUMPED in found


HEIGHTS_M = np.array([0.006, -0.002, 0.0, 0.00005, -0.01])


class CanContract:
    """What a CAN driver promises with its node."""

    kind: type[Driver]

    def node(self) -> CanNode:
        raise NotImplementedError

    def newest_s(self, driver: Driver) -> float:
        """A tick of the driver: read, and write as a site does."""
        newest_s = driver.read(time.monotonic()).oldest_s
        if isinstance(driver, ExoskeletonDriver):
            driver.push(time.monotonic(), [0.0] * 5, enabled=True)
        else:
            driver.move(time.monotonic(), 0.0, 0.0, [0.0] * 5, released=False)
        return newest_s

    @pytest.fixture
    def rig(self) -> Iterator[Rig]:
        rig = Rig({}, self.node())
        yield rig
        rig.close()

    @pytest.fixture
    def driver(self, rig: Rig) -> Iterator[Driver]:
        driver = self.kind(rig.can)
        rig.until(lambda: None, lambda: self.newest_s(driver) > 0.0)
        yield driver
        driver.line.close()

    def test_no_frame_is_refused_or_unknown(self, rig: Rig, driver: Driver) -> None:
        for _ in range(50):
            rig.turn()
            driver.read(time.monotonic())
        assert driver.line.connected
        assert driver.line.problem is None
        assert [receiver.refused for receiver in driver.receivers] == [0] * len(driver.receivers)
        assert (driver.line.unknown, rig.nodes[0].refused, rig.bus.not_understood) == (0, 0, 0)

    @pytest.mark.parametrize("sends", [True, False])
    def test_the_bus_goes_away_and_comes_back(self, rig: Rig, driver: Driver, sends: bool) -> None:
        """Also where the driver only listens, and so finds out by nothing that it sends."""

        def tick() -> object:
            return self.newest_s(driver) if sends else driver.read(time.monotonic())

        def timed_tick() -> None:
            start_s = time.monotonic()
            tick()
            assert time.monotonic() - start_s < 0.2  # losing a device holds no loop up

        for times in (1, 2):
            rig.bus.unplug()
            alone(timed_tick, lambda: not driver.line.connected)
            assert driver.line.times_lost == times
            last_s = self.newest_s(driver)
            alone(tick, lambda: driver.line.problem is not None)
            assert isinstance(driver.line.problem, DeviceAbsent)
            assert str(rig.can) in str(driver.line.problem)
            assert self.newest_s(driver) == last_s  # what is old stays as old as it is
            rig.bus.plug()
            rig.until(tick, lambda last_s=last_s: driver.read(time.monotonic()).oldest_s > last_s)  # type: ignore[misc]

    def test_a_bus_that_is_off_is_named_until_it_is_on_again_and_neither_start_nor_loss_is_a_fault(
        self, rig: Rig, driver: Driver
    ) -> None:
        def faults() -> list[Fault]:
            self.newest_s(driver)
            return driver.faults(time.monotonic())

        assert faults() == []
        rig.bus.turn_off()
        rig.until(lambda: None, faults)
        assert faults() == [
            Fault(FaultCode.BUS_OFF, detail=str(rig.can)),
        ]
        rig.bus.turn_on()
        rig.until(lambda: None, lambda: faults() == [])
        rig.bus.unplug()
        rig.until(lambda: None, lambda: faults() == [] and not driver.line.connected)

    def test_a_node_that_hides_its_outputs_is_a_fault(
        self, rig: Rig, driver: Driver, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(sim_sensors.devices.can_node, "STATE_EVERY", 10**9)
        hidden = Fault(FaultCode.STATE_NOT_REPORTED)
        rig.until(lambda: self.newest_s(driver), lambda: hidden in driver.faults(time.monotonic()))

    def test_a_second_sender_of_the_sites_frames_is_a_fault(self, rig: Rig, driver: Driver) -> None:
        name = driver.line.sends[0]
        rig.bus.intruder = Intruder({name: dict.fromkeys(("enabled", "x", "y", *FINGERS), 0.0)})
        rig.bus.intruder.active = True
        foreign = Fault(FaultCode.FOREIGN_FRAMES, name)
        rig.until(lambda: self.newest_s(driver), lambda: foreign in driver.faults(time.monotonic()))

    def test_frames_that_are_all_damaged_are_a_fault(self, rig: Rig, driver: Driver) -> None:
        rig.nodes[0].transmitter.damage = ("counter", 1.0)
        rig.until(lambda: self.newest_s(driver), lambda: driver.faults(time.monotonic()))
        assert driver.faults(time.monotonic())[0].code is FaultCode.FRAMES_DAMAGED


class TestExoskeleton(CanContract):
    kind = ExoskeletonDriver

    def node(self) -> Exoskeleton:
        node = Exoskeleton()
        node.measure(-0.17, 0.002, HEIGHTS_M)
        return node

    def test_pose_and_heights_come_in_m(self, driver: ExoskeletonDriver) -> None:
        hand = driver.hand
        assert (hand.place.x_m, hand.place.y_m) == (pytest.approx(-0.17), pytest.approx(0.002))
        assert hand.place.z_m == pytest.approx(HEIGHTS_M, abs=2.6e-6)

    def test_forces_reach_the_fingers_while_enabled_and_end_by_themselves(self, rig: Rig, driver: Driver) -> None:
        (node,) = rig.nodes
        assert isinstance(node, Exoskeleton)
        assert isinstance(driver, ExoskeletonDriver)
        force_n = [0.0, 0.5, 1.25, 10.0, 99.0]

        def drive() -> None:
            driver.read(time.monotonic())
            driver.push(time.monotonic(), force_n, enabled=True)

        rig.until(drive, lambda: node.force_n(rig.loop.now())[2] > 0.0)
        assert node.force_n(rig.loop.now()) == pytest.approx([0.0, 0.5, 1.25, 10.0, 10.23])
        driver.push(time.monotonic(), force_n, enabled=False)
        rig.until(lambda: None, lambda: not node.force_n(rig.loop.now()).any(), patience_s=0.09)
        driver.push(time.monotonic(), force_n, enabled=True)
        rig.until(lambda: None, lambda: node.force_n(rig.loop.now()).any())
        start_s = time.monotonic()  # from here on the driver is gone
        rig.until(lambda: None, lambda: not node.force_n(rig.loop.now()).any())
        assert time.monotonic() - start_s >= 0.1

    def test_an_exoskeleton_is_confirmed_off_only_by_its_own_reports(self, rig: Rig, driver: ExoskeletonDriver) -> None:
        def drive(newton: float, enabled: bool) -> None:
            driver.read(time.monotonic())
            driver.push(time.monotonic(), [newton] * 5, enabled)

        rig.until(lambda: drive(2.5, True), lambda: "pushes with up to 2.50 N" in driver.unconfirmed(0.0))
        rig.until(lambda: drive(0.0, True), lambda: driver.unconfirmed(0.0) == "enabled")
        stopped_s = time.monotonic()
        assert driver.unconfirmed(stopped_s) == "no report"
        rig.until(lambda: drive(2.5, False), lambda: driver.unconfirmed(stopped_s) == "")
        rig.bus.unplug()
        rig.until(lambda: drive(0.0, False), lambda: driver.unconfirmed(stopped_s) == "not connected")


class TestTelemanipulator(CanContract):
    kind = TelemanipulatorDriver

    def node(self) -> Telemanipulator:
        node = Telemanipulator()
        node.measure(0.1, -0.02, HEIGHTS_M, np.array([0.0, 0.15, 0.3, 2.0, 5.0]))
        return node

    def test_positions_and_forces_come_in_si(self, driver: TelemanipulatorDriver) -> None:
        measured = driver.measured
        assert (measured.x_m, measured.y_m) == (pytest.approx(0.1), pytest.approx(-0.02))
        assert measured.z_m == pytest.approx(HEIGHTS_M, abs=2.6e-6)
        assert measured.force_n == pytest.approx([0.0, 0.15, 0.3, 2.0, 5.0])

    def test_set_points_reach_the_servos_and_stop_where_it_is(self, rig: Rig, driver: TelemanipulatorDriver) -> None:
        (node,) = rig.nodes
        assert isinstance(node, Telemanipulator)
        wanted = [0.006, -0.002, 0.0, 0.001, 0.01]

        def drive() -> None:
            driver.read(time.monotonic())
            driver.move(time.monotonic(), -0.3, 0.05, wanted, released=False)

        def followed() -> bool:
            x_m, y_m, z_m = node.setpoint_m(rig.loop.now())
            return np.allclose([x_m, y_m, *z_m], [-0.3, 0.05, *wanted], atol=1.1e-5)

        rig.until(drive, followed)
        rig.until(lambda: None, lambda: node.setpoint_m(rig.loop.now())[0] == 0.1)
        assert node.setpoint_m(rig.loop.now())[2] == pytest.approx(HEIGHTS_M)

    def test_its_release_is_confirmed_only_by_its_own_reports(self, rig: Rig, driver: TelemanipulatorDriver) -> None:
        def drive(released: bool) -> None:
            driver.read(time.monotonic())
            driver.move(time.monotonic(), 0.0, 0.0, [0.0] * 5, released=released)

        rig.until(lambda: drive(False), lambda: driver.unconfirmed(0.0) == "not released")
        assert (driver.following.hand_alive, driver.following.heights_alive) == (True, True)
        stopped_s = time.monotonic()
        assert driver.unconfirmed(stopped_s) == "no report"
        rig.until(lambda: drive(True), lambda: driver.unconfirmed(stopped_s) == "")
        rig.until(lambda: driver.read(time.monotonic()), lambda: not driver.following.heights_alive)
        assert driver.unconfirmed(stopped_s) == ""  # its time-out releases it, too
        rig.bus.unplug()
        rig.until(lambda: drive(True), lambda: driver.unconfirmed(stopped_s) == "not connected")


def test_a_set_point_for_another_number_of_fingers_is_refused() -> None:
    driver = TelemanipulatorDriver(CanAddress(interface="virtual", channel="nobody"))
    with pytest.raises(ValueError, match="zip"):
        driver.move(0.0, 0.0, 0.0, [0.0] * (len(FINGERS) - 1), released=False)
    driver.line.close()
