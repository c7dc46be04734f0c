"""The gate with the emulated telemanipulator in the simulated world, in virtual time: normal work is never a fault."""

import math
from collections import deque
from collections.abc import Callable

import numpy as np
import pytest

from common.buses.can_frames import FrameSender
from common.faults.fault import FaultCode
from common.faults.texts import fault_text
from common.fingers import FINGERS
from common.limits import LEFT_J
from common.scenes.scene import load_scene
from remote_site.safety.limit_flags import Limit
from remote_site.safety.patient_gate import PatientGate
from remote_site.safety.setpoints import GatedCommand
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.physics.remote_world import RemoteWorld

DT = 0.002
INDEX = FINGERS.index("index")
Wanted = tuple[float, float, float]
"""Where the operator's hand is: x, y and the height of all fingers, m."""


class Loop:
    """Gate, bus, telemanipulator and world, one tick at a time; reports and set-points each take `delay` ticks."""

    def __init__(self, delay: int = 1, scene: str = "materials") -> None:
        self.gate, self.robot = PatientGate(), Telemanipulator()
        self.world = RemoteWorld(load_scene(scene), seed=1)
        self.hand, self.heights = FrameSender("HandSetpoint"), FrameSender("HeightSetpoint")
        self.ticks = 0
        self.bus_cut = False
        self.servos_dead = False
        self.held_m: float | None = None
        """The index finger's encoder is stuck here, m."""
        self.joint_stuck = False
        """And so is its joint."""
        self.largest_n = 0.0
        self.sent: deque[GatedCommand] = deque(maxlen=delay)
        self.reports = deque([self.report()] * delay, maxlen=delay)

    def report(self) -> tuple[float, float, list[float], list[float]]:
        world = self.world
        force_n = np.clip(world.measured_force_n, 0.0, 10.23).tolist()
        z_m = np.minimum(world.z_m, 0.010235).tolist()
        if self.held_m is not None:
            z_m[INDEX] = self.held_m
        return world.x_m, world.y_m, z_m, force_n

    def tick(self, wanted: Wanted, engaged: bool = True, age_s: float = 0.0) -> GatedCommand:
        self.ticks += 1
        now_s = self.ticks * DT
        if len(self.sent) == self.sent.maxlen and not self.bus_cut:
            self.obey(self.sent[0], now_s)
        x_m, y_m, z_m = self.robot.setpoint_m(now_s)
        if self.servos_dead:
            x_m, y_m, z_m = self.world.x_m, self.world.y_m, self.world.z_m
        self.world.step(DT, x_m, y_m, z_m, np.zeros(5))
        self.robot.measure(self.world.x_m, self.world.y_m, self.world.z_m, self.world.measured_force_n)
        self.largest_n = max(self.largest_n, *self.world.force_n)
        self.reports.append(self.report())
        seen_x_m, seen_y_m, seen_z_m, force_n = self.reports[0]
        command = self.gate.step(
            now_s,
            engaged,
            age_s,
            wanted_x_m=wanted[0],
            wanted_y_m=wanted[1],
            wanted_z_m=[wanted[2]] * 5,
            measured_x_m=seen_x_m,
            measured_y_m=seen_y_m,
            measured_z_m=seen_z_m,
            force_n=force_n,
            force_age_s=0.0,
            heater_drive=[0.0] * 5,
            sensor_c=[33.0] * 5,
            ambient_c=[23.0] * 5,
            sensor_age_s=[0.0] * 5,
            in_contact=[False] * 5,
        )
        self.sent.append(command)
        return command

    def obey(self, command: GatedCommand, now_s: float) -> None:
        if self.joint_stuck and self.held_m is not None:
            command.z_m[INDEX] = self.held_m
        heights = dict(zip(FINGERS, (z_m * 1e3 for z_m in command.z_m), strict=True))
        for frame in (
            self.hand.encode({"x": command.x_m * 1e3, "y": command.y_m * 1e3}),
            self.heights.encode({"released": float(command.released), **heights}),
        ):
            self.robot.feed(frame.arbitration_id, bytes(frame.data), now_s)


def wild(t_s: float) -> Wanted:
    """Strokes, presses and taps across the whole bench, faster and deeper than the gate lets through."""
    return 0.5 * math.sin(1.3 * t_s), 0.2 * math.sin(0.7 * t_s), 0.012 * math.cos(3.1 * t_s + math.sin(9.0 * t_s))


def pressing(t_s: float) -> Wanted:
    """Strokes the first objects and presses as deep as the gate lets it."""
    return -0.17 + 0.03 * math.sin(4.0 * t_s), 0.0, -0.010 if math.sin(1.5 * t_s) > -0.3 else 0.004


@pytest.mark.parametrize("move", [wild, pressing])
@pytest.mark.parametrize("delay", [1, 10])
def test_hard_work_is_no_fault(move: Callable[[float], Wanted], delay: int) -> None:
    loop = Loop(delay)
    for tick in range(3000):
        assert loop.tick(move(tick * DT)).fault is None
    assert loop.largest_n > 1.0  # it did touch


@pytest.mark.parametrize(("scene", "over_m"), [("materials", 0.0), ("phantom", 0.2)])
def test_gaps_and_new_engagements_are_no_fault(scene: str, over_m: float) -> None:
    loop = Loop(2, scene)
    for tick in range(4000):
        engaged, age_s = tick % 1000 < 800, 0.2 if tick % 700 < 100 else 0.0
        x_m, y_m, z_m = pressing(tick * DT)
        assert loop.tick((x_m + over_m, y_m, z_m), engaged, age_s).fault is None
    assert loop.largest_n > 0.5


def test_a_released_hand_stops_and_no_finger_sinks() -> None:
    loop = Loop()
    for tick in range(2000):
        if loop.largest_n > 1.0 and abs(loop.world.speed_m_s) > 0.05:
            break
        loop.tick(pressing(tick * DT))
    assert loop.largest_n > 1.0
    loop.tick((0.3, 0.2, -0.01), engaged=False)
    loop.tick((0.3, 0.2, -0.01), engaged=False)
    x_m, z_m = loop.world.x_m, loop.world.z_m
    for _ in range(1000):
        loop.tick((0.3, 0.2, -0.01), engaged=False)
        assert abs(loop.world.x_m - x_m) < 0.0015
        assert (loop.world.z_m - z_m > -0.0005).all()
    assert loop.world.z_m == pytest.approx(0.006, abs=1e-4)


def swinging(tick: int) -> Wanted:
    return 0.1 * math.sin(tick * DT), 0.0, 0.006


@pytest.mark.parametrize(("broken", "within_s"), [("servos_dead", 0.5), ("bus_cut", 1.0)])
def test_dead_or_unreachable_servos_are_a_fault(broken: str, within_s: float) -> None:
    loop = Loop()
    for tick in range(500):
        loop.tick(swinging(tick))
    setattr(loop, broken, True)
    faults = [loop.tick(swinging(tick)).fault for tick in range(500, 1000)]
    why = next(fault for fault in faults if fault is not None)
    assert (why.code, why.where) == (FaultCode.SET_POINT_MISSED, "hand's x")
    assert faults.index(why) * DT < within_s


@pytest.mark.parametrize("joint", [True, False])
def test_one_finger_that_stands_still_while_it_is_sent_down_is_a_fault(joint: bool) -> None:
    loop = Loop()
    loop.joint_stuck = joint
    for _ in range(500):
        loop.tick((0.0, 0.0, 0.006))
    loop.held_m = loop.report()[2][INDEX]
    faults = [loop.tick((0.0, 0.0, 0.006 - 0.00002 * tick)).fault for tick in range(500)]
    why = next(fault for fault in faults if fault is not None)
    assert (why.code, why.where) == (FaultCode.SET_POINT_MISSED, "index")
    sent_2_mm = 100
    assert (faults.index(why) - sent_2_mm) * DT < 0.45


def test_a_bus_that_is_cut_for_a_moment_is_no_fault() -> None:
    loop = Loop()
    for tick in range(3000):
        loop.bus_cut = tick % 500 < 60  # 120 ms: the telemanipulator has stopped by itself meanwhile
        assert loop.tick((0.1 * math.sin(2.0 * tick * DT), 0.0, 0.006)).fault is None


@pytest.mark.parametrize(("scene", "over_m"), [("materials", -0.165), ("phantom", 0.0), ("phantom", 0.045)])
@pytest.mark.parametrize("hz", [2.0, 8.0])
def test_tapping_as_hard_and_as_fast_as_a_hand_can_is_no_fault(scene: str, over_m: float, hz: float) -> None:
    loop, left_mj = Loop(3, scene), 0.0
    for tick in range(2000):
        t_s = tick * DT
        z_m = 0.004 if t_s < 1.5 else 0.003 - 0.012 * math.sin(math.pi * hz * t_s) ** 2
        command = loop.tick((over_m, 0.0, z_m))
        assert command.fault is None
        assert not any(bits & Limit.ENERGY for bits in command.limited)
        left_mj = max(left_mj, *loop.gate.left_mj)
    assert loop.largest_n > 2.0
    assert left_mj < 0.5e3 * LEFT_J


@pytest.mark.parametrize(("hz", "reach_m"), [(15.0, 0.5e-3), (25.0, 1e-3)])
def test_set_points_that_shake_in_contact_as_no_hand_does_are_a_fault_and_the_fingers_leave(
    hz: float, reach_m: float
) -> None:
    loop = Loop()
    for tick in range(round(2.2 / DT)):
        t_s = tick * DT
        z_m = 0.004 if t_s < 1.5 else -0.002 + reach_m * math.sin(2.0 * math.pi * hz * t_s)
        command = loop.tick((-0.165, 0.0, z_m))
        if command.fault:
            break
    assert command.fault is not None
    assert f": force swings at {hz:.0f} Hz by " in fault_text(command.fault)
    assert t_s - 1.5 < 0.6
    for _ in range(500):
        loop.tick((-0.165, 0.0, -0.002))
    assert loop.world.z_m == pytest.approx(0.006, abs=1e-4)


def test_a_hand_that_came_back_from_elsewhere_touches_softly() -> None:
    """80 mm away and 8 mm deeper, on a block; a hand that has been followed all the way comes down with a blow."""
    blows = []
    for away_m in (0.0, 0.08):
        loop = Loop()
        for tick in range(1000):
            loop.tick((-0.085 - 0.08 + away_m, 0.0, 0.006), engaged=tick < 700 or not away_m)
        loop.largest_n = 0.0
        for _ in range(800):
            assert loop.tick((-0.165, 0.0, -0.002)).fault is None
        assert loop.world.x_m == pytest.approx(-0.165, abs=1e-3)
        resting_n = max(loop.world.force_n)
        assert resting_n > 1.0
        blows.append(loop.largest_n / resting_n)
    assert blows[1] < 1.02 < 1.1 < blows[0]
