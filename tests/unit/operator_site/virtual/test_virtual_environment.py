"""A scene under the operator's own fingers: contact, modes, grooves, and data known before the touch."""

import numpy as np
import pytest

from common.exploration.contact_detector import CONTACT_ON_N
from common.fingers import FINGER_Y_M, FINGERS
from common.scenes.scene import Scene, load_scene, scene_names
from common.scenes.surfaces import surface_kind
from common.wire.messages import MAX_EVENTS, Event, EventKind, ExplorationMode, ThermalStatus, Touch
from common.wire.packets import LinkState
from operator_site.virtual.virtual_environment import VirtualEnvironment

TICK_S = 0.002
UP_M, DOWN_M = 0.005, -0.001
INDEX = FINGERS.index("index")


class Hand:
    """A hand that follows commands over a scene, and its contacts."""

    def __init__(self, scene: Scene, fingers: tuple[str, ...] = FINGERS, seed: int = 0):
        self.environment = VirtualEnvironment(scene, fingers, seed)
        self.time_s, self.x_m, self.y_m, self.z_m = 10.0, 0.0, 0.0, UP_M
        self.events: list[Event] = []
        self.modes: list[int] = []

    def go(self, seconds: float = 0.0, x_m: float | None = None, z_m: float | None = None) -> Touch:
        """Move evenly for this time, s; zero moves at once."""
        ticks = max(1, round(seconds / TICK_S))
        from_x, from_z = self.x_m, self.z_m
        to_x, to_z = from_x if x_m is None else x_m, from_z if z_m is None else z_m
        for tick in range(1, ticks + 1):
            self.time_s += TICK_S
            self.x_m = from_x + (to_x - from_x) * tick / ticks
            self.z_m = from_z + (to_z - from_z) * tick / ticks
            self.events += self.environment.step(self.time_s, self.x_m, self.y_m, (self.z_m,) * len(FINGERS))
            self.modes.append(int(self.row()["mode"]))
        return self.packet()

    def packet(self) -> Touch:
        return self.environment.packet(1, 1, round(self.time_s * 1e9), LinkState.ENGAGED)

    def row(self, finger: int = INDEX) -> dict[str, float]:
        return self.packet().rows[finger]._asdict()

    def count(self, kind: EventKind) -> int:
        return sum(event.kind is kind and event.finger == INDEX for event in self.events)


def lowered(where: Scene, x_m: float = 0.020, seed: int = 0) -> Hand:
    """A hand that lies on a scene."""
    hand = Hand(where, seed=seed)
    hand.go(0.1, x_m=x_m)
    hand.go(0.1, z_m=DOWN_M)
    hand.go(0.3)
    return hand


def scene(surface: str = "plain_pvc", **more: object) -> Scene:
    block = {"name": "block", "material": "pvc", "surface": surface, "x_m": 0.0, "length_m": 0.1, **more}
    return Scene.model_validate({"name": "small", "objects": [block]})


def test_a_free_finger_above_an_object_knows_what_it_will_touch() -> None:
    hand = Hand(scene("closely_grooved_pvc", height_m=0.001, absolute_c=30.0))
    packet = hand.go(1.0, x_m=0.05)
    row, pvc = hand.row(), surface_kind("closely_grooved_pvc")
    assert (row["mode"], row["contact"], row["contact_force_n"]) == (ExplorationMode.FREE, 0.0, 0.0)
    assert row["surface_z_m"] == pytest.approx(0.001)
    assert (row["stiffness_n_m"], row["k_tap"], row["k_stroke_v"]) == (pvc.stiffness_n_m, pvc.k_tap, pvc.k_stroke_v)
    assert row["conductivity_w_mk"] == pytest.approx(0.17)
    assert (row["object_c"], row["probability"], row["thermal_status"]) == (30.0, 1.0, ThermalStatus.IDENTIFIED)
    assert packet.materials == ("pvc",) * len(FINGERS)
    assert hand.events == [], "grooves under a free finger are not crossed"


def test_a_finger_over_nothing_or_an_unused_one_touches_nothing() -> None:
    hand = Hand(scene(), fingers=("index",))
    hand.go(0.1, x_m=-0.05, z_m=DOWN_M)
    assert not hand.packet().block.any()
    packet = hand.go(0.1, x_m=0.05)
    assert packet.block[INDEX].any()
    assert not np.delete(packet.block, INDEX, axis=0).any()
    assert packet.materials == tuple("pvc" if finger == "index" else "" for finger in FINGERS)


def test_fingers_sit_side_by_side_across_the_stroke() -> None:
    hand = Hand(scene(y_m=0.01, width_m=0.02))
    packet = hand.go(0.1, x_m=0.05)
    assert [bool(row.any()) for row in packet.block] == [0.01 <= y_m < 0.03 for y_m in FINGER_Y_M]


@pytest.mark.parametrize(("surface", "stiffness_n_m"), [("plain_pvc", 4000.0), ("foam", 400.0)])
def test_contact_is_the_force_of_a_finger_so_deep(surface: str, stiffness_n_m: float) -> None:
    hand = Hand(scene(surface))
    hand.go(0.1, x_m=0.05)
    depth_m = CONTACT_ON_N / stiffness_n_m
    assert hand.go(0.1, z_m=-0.9 * depth_m).rows[INDEX].contact == 0.0
    hand.go(0.1, z_m=-1.1 * depth_m)
    row = hand.row()
    assert row["contact"] == 1.0
    assert row["contact_force_n"] == pytest.approx(1.1 * CONTACT_ON_N)
    hand.go(0.1, z_m=-0.0099)
    assert hand.row()["contact_force_n"] == pytest.approx(min(10.5, 0.0099 * stiffness_n_m)), "as far as a packet goes"


def test_a_virtual_stiffness_is_that_of_all_objects() -> None:
    foam = scene("foam").model_copy(update={"virtual_stiffness_n_m": 4000.0})
    hand = Hand(foam)
    hand.go(0.1, x_m=0.05)
    assert hand.row()["stiffness_n_m"] == 4000.0


def test_a_tap_reports_its_approach_speed_once_for_each_finger() -> None:
    hand = Hand(scene())
    hand.go(0.1, x_m=0.05)
    hand.go(0.15, z_m=DOWN_M)
    assert [event.finger for event in hand.events] == list(range(len(FINGERS)))
    assert {event.kind for event in hand.events} == {EventKind.TAP}
    assert [event.value for event in hand.events] == pytest.approx([0.04] * len(FINGERS), rel=0.01)
    hand.go(1.0)
    hand.go(0.15, z_m=UP_M)
    assert hand.row()["mode"] == ExplorationMode.FREE
    hand.go(0.15, z_m=DOWN_M)
    assert [event.ident for event in hand.events] == list(range(1, 2 * len(FINGERS) + 1))


def test_modes_are_those_of_the_paper() -> None:
    hand = Hand(scene())
    hand.go(0.1, x_m=0.02)
    hand.go(0.1, z_m=DOWN_M)
    hand.go(0.5)
    hand.go(1.0, x_m=0.07)
    hand.go(0.5)
    hand.go(0.1, z_m=UP_M)
    found = [mode for mode, before in zip(hand.modes, [-1, *hand.modes], strict=False) if mode != before]
    free, tapping, quiescent, stroking = ExplorationMode
    assert found == [free, tapping, quiescent, stroking, quiescent, free]


@pytest.mark.parametrize(
    ("surface", "grooves"), [("closely_grooved_pvc", 30), ("widely_grooved_pvc", 8), ("plain_pvc", 0)]
)
def test_each_crossed_groove_is_reported_once(surface: str, grooves: int) -> None:
    hand = lowered(scene(surface))
    hand.go(1.2, x_m=0.082)
    assert hand.count(EventKind.GROOVE) == pytest.approx(grooves, abs=1)
    forth = hand.count(EventKind.GROOVE)
    hand.go(1.2, x_m=0.020)
    assert hand.count(EventKind.GROOVE) - forth == pytest.approx(grooves, abs=1)
    kind = surface_kind(surface).grooves
    assert {event.value for event in hand.events if event.kind is EventKind.GROOVE} == (
        {kind.impulse_rad_s} if kind else set()
    )


def test_the_time_of_a_groove_is_that_of_its_crossing() -> None:
    hand = lowered(scene("closely_grooved_pvc"))
    for way_m in (0.060, -0.060):
        before = len(hand.events)
        hand.go(0.6, x_m=hand.x_m + way_m)
        times_ns = [event.time_ns for event in hand.events[before:] if event.finger == INDEX]
        assert np.diff(times_ns) == pytest.approx(20e6, rel=1e-3), "2 mm at 100 mm/s, in ticks of 2 ms or between"


@pytest.mark.long
def test_the_session_is_drawn_with_the_seed() -> None:
    def drawn(seed: int) -> tuple[float, list[int]]:
        hand = lowered(load_scene("materials"), x_m=0.110, seed=seed)
        hand.go(1.0, x_m=0.150)
        return hand.row()["object_c"], [event.time_ns for event in hand.events if event.kind is EventKind.GROOVE]

    assert drawn(1) == drawn(1)
    temperatures, crossings = zip(*(drawn(seed) for seed in range(4)), strict=True)
    assert len(set(temperatures)) == 4
    assert all(20.0 <= object_c <= 26.0 for object_c in temperatures)
    assert len(set(map(tuple, crossings))) == 4


def test_zones_of_one_body_have_one_temperature_and_other_bodies_others() -> None:
    hand = Hand(load_scene("materials"))
    found = []
    for x_m in (0.03, 0.08, 0.13, 0.18, 0.24):
        hand.go(x_m=x_m)
        found.append(hand.row()["object_c"])
    assert len(set(found[:4])) == 1
    assert found[4] != found[0]


def test_a_clock_set_back_restarts_without_repeating_an_event() -> None:
    hand = Hand(scene())
    hand.go(0.1, x_m=0.05)
    hand.go(0.15, z_m=DOWN_M)
    hand.time_s -= 5.0
    hand.go(0.5)
    assert hand.row()["mode"] == ExplorationMode.QUIESCENT
    idents = [event.ident for event in hand.events]
    assert idents == list(range(1, len(idents) + 1))


def test_a_leaping_hand_reports_at_most_a_packet() -> None:
    hand = lowered(scene("closely_grooved_pvc"), x_m=0.01)
    hand.go(0.3, x_m=0.03)
    packet = hand.go(x_m=0.09)
    assert len(packet.events) == MAX_EVENTS
    assert Touch.decode(packet.encode()) == packet


@pytest.mark.parametrize("name", scene_names())
def test_every_scene_makes_acceptable_packets(name: str) -> None:
    hand = Hand(load_scene(name), seed=3)
    for x_m in np.arange(-0.25, 0.35, 0.01):
        packet = hand.go(0.01, x_m=float(x_m), z_m=DOWN_M)
        assert Touch.decode(packet.encode()) == packet
