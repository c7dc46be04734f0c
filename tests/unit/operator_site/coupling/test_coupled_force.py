"""Force through clutch and scale: as at the remote finger, without a step at a change, within the gate's limits."""

import math
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.config.site_models import RenderingConfig
from common.limits import (
    COUPLING_STEP_N,
    FORCE_RAMP_UP_N_S,
    GAP_S,
    MOTION_SCALES,
    PRODUCED_J,
    REMOTE_LOW_M,
)
from common.link.session_state import Refused
from common.wire.packets import N
from operator_site.coupling.coupling import EDGE_HEIGHT_M, Places
from operator_site.coupling.motion_coupling import MotionCoupling
from operator_site.force.coupled_contact import EDGE_N_M
from operator_site.gated_rendering import GatedRendering
from operator_site.safety.force_limits import FORCE_FALL_N_S
from tests.unit.operator_site.touches import INDEX, tick_input, touch

TICK_S = 0.002
SURFACE_M, STIFFNESS_N_M = 0.002, 380.0
"""Height and stiffness of the remote surface: no stiffer than the exoskeleton displays."""
MOST_M = 0.2e-3
"""Largest motion of a finger in a tick, m: 0.1 m/s."""


@dataclass
class Rig:
    """An operator's index finger on a remote surface."""

    stiffness_n_m: float = STIFFNESS_N_M
    damping_n_s_m: float = 0.0
    rendering: GatedRendering = field(default_factory=lambda: GatedRendering(RenderingConfig(), TICK_S, GAP_S))
    coupling: MotionCoupling = field(default_factory=lambda: MotionCoupling(lambda *_: None))
    t_s: float = 10.0
    z_m: float = 0.008
    x_m: float = 0.0
    engaged: bool = True
    force_n: float = 0.0
    produced_j: float = 0.0

    def __post_init__(self) -> None:
        self.touch = touch(stiffness_n_m=self.stiffness_n_m, damping_n_s_m=self.damping_n_s_m, surface_z_m=SURFACE_M)
        self.run(200)  # the ceiling of the force rises after engaging

    def tick(self) -> float:
        """Step all; return the force on the finger, N."""
        self.t_s += TICK_S
        z_m = (self.z_m,) * N
        self.coupling.step(self.engaged, 7, Places(self.x_m, 0.0, z_m))
        self.coupling.pressed_n = max(self.rendering.pushed_n)
        now = tick_input(
            time_s=self.t_s,
            engaged=self.engaged,
            touch=1,
            x_m=self.x_m,
            z_m=z_m,
            pose_s=self.t_s,
            heights_s=self.t_s,
            plate_age_s=(math.inf,) * N,
        )
        output = self.rendering.step(now, self.touch, self.coupling.now)
        assert output.fault is None
        self.force_n = output.force_n[INDEX]
        self.produced_j = 1e-3 * self.rendering.produced_mj["index"]["most"]
        return self.force_n

    def run(self, ticks: int, speed_m_s: float = 0.0) -> list[float]:
        forces = []
        for _ in range(ticks):
            self.z_m += speed_m_s * TICK_S
            forces.append(self.tick())
        return forces

    def ask(self, change: str) -> None:
        if change in ("open", "closed"):
            self.coupling.ask("clutch", {"open": change == "open"})
        elif change in ("pause", "engage"):
            self.engaged = change == "engage"
        elif change:
            self.coupling.ask("scale", {"scale": int(change)})

    @property
    def command_m(self) -> float:
        return self.coupling.now.command(Places(self.x_m, 0.0, (self.z_m,) * N)).z_m[INDEX]

    def press(self, scale: int) -> None:
        """Lower the finger to 1 mm above the surface, change the scale, and press the remote finger 1.5 mm in."""
        self.run(1000, -0.0025)
        self.ask(str(scale))
        self.run(1000, -0.00125 * scale)

    @property
    def law_n(self) -> float:
        """Force of the remote surface at the command, N."""
        return STIFFNESS_N_M * max(0.0, SURFACE_M - self.command_m)


def largest_change_n(forces: list[float]) -> float:
    return max(abs(after - before) for before, after in pairwise(forces))


@pytest.mark.parametrize("scale", MOTION_SCALES)
def test_the_force_is_that_of_the_remote_surface_at_the_command(scale: int) -> None:
    rig = Rig()
    rig.press(scale)
    assert rig.command_m == pytest.approx(SURFACE_M - 0.0015)
    assert rig.force_n == pytest.approx(rig.law_n, abs=1e-3)


@pytest.mark.parametrize("scale", MOTION_SCALES)
def test_the_damping_is_that_of_the_remote_surface_at_the_commanded_speed(scale: int) -> None:
    rig = Rig(stiffness_n_m=100.0, damping_n_s_m=1.0)
    rig.run(1000, -0.0025)
    rig.ask(str(scale))
    rig.run(31, -0.04 * scale)
    assert rig.force_n == pytest.approx(100.0 * (SURFACE_M - rig.command_m) + 0.04, abs=2e-3)


@pytest.mark.long
@pytest.mark.parametrize("scale", MOTION_SCALES)
def test_an_opened_clutch_lets_the_force_fade_and_closing_brings_it_back(scale: int) -> None:
    rig = Rig()
    rig.press(scale)
    pressed_n, command_m = rig.force_n, rig.command_m
    rig.ask("open")
    forces = [pressed_n, *rig.run(100)]
    assert largest_change_n(forces) <= COUPLING_STEP_N + 1e-9
    assert forces[-1] == 0.0
    assert set(rig.run(500, 0.01)) == {0.0}
    assert rig.command_m == command_m
    rig.ask("closed")
    forces = [0.0, *rig.run(500)]
    assert largest_change_n(forces) <= COUPLING_STEP_N + 1e-9
    assert 0.5 * pressed_n <= forces[-1] <= pressed_n + 1e-9, "as much as the account of energy pays at once"
    rig.run(500, 0.002 * scale)
    rig.run(500, -0.002 * scale)
    assert rig.command_m == pytest.approx(command_m)
    assert rig.force_n == pytest.approx(pressed_n, abs=1e-3), "after a lift, all of it"


def test_a_free_hand_feels_nothing_where_it_goes() -> None:
    rig = Rig()
    rig.ask("open")
    rig.run(10)
    assert set(rig.run(1500, -0.006)) == {0.0}, "18 mm down, through the surface"


def test_the_scale_does_not_change_under_pressure() -> None:
    rig = Rig()
    rig.press(1)
    with pytest.raises(Refused, match="a finger presses"):
        rig.ask("5")
    rig.ask("open")
    rig.run(100)
    rig.ask("5")
    rig.ask("closed")
    assert largest_change_n([0.0, *rig.run(300)]) <= COUPLING_STEP_N + 1e-9
    assert 0.3 <= rig.force_n <= rig.law_n, "a softer spring stores more, and the account pays less of it at once"


def test_a_soft_wall_is_felt_before_the_lowest_remote_height() -> None:
    rig = Rig(stiffness_n_m=0.0)
    rig.z_m = -0.008
    rig.tick()
    rig.ask("open")
    rig.z_m = 0.0
    rig.tick()
    rig.ask("closed")
    rig.run(400)
    assert rig.force_n == 0.0
    rig.run(1000, -0.0015)
    assert rig.command_m < REMOTE_LOW_M
    assert rig.force_n == pytest.approx(EDGE_N_M * (REMOTE_LOW_M + EDGE_HEIGHT_M + 0.008 - rig.z_m), abs=0.02)


acts = st.lists(
    st.tuples(
        st.sampled_from(["open", "closed", "1", "2", "5", "pause", "engage", "", ""]),
        st.floats(-1.0, 1.0),
        st.integers(1, 60),
    ),
    max_size=25,
)


@pytest.mark.long
@given(acts)
def test_no_change_makes_a_step_in_force_or_energy(sequence: list[tuple[str, float, int]]) -> None:
    rig = Rig(z_m=SURFACE_M + 0.5e-3)
    engaged_s = 10.0
    for change, speed, ticks in sequence:
        was_engaged = rig.engaged
        with suppress(Refused):
            rig.ask(change)
        if rig.engaged is not was_engaged:
            engaged_s = rig.t_s
        for _ in range(ticks):
            before_n, before_m = rig.force_n, rig.z_m
            rig.z_m = min(0.0103, max(-0.0103, rig.z_m + speed * MOST_M))
            rig.tick()
            # The law of the contact, which the hand's own motion follows, at the stiffest wall.
            law_n = rig.rendering.wall.stiffest_n_m * abs(rig.z_m - before_m)
            up_n, down_n = COUPLING_STEP_N, COUPLING_STEP_N
            if rig.t_s - engaged_s < 0.5:  # the gate's own ramps on engaging and pausing
                up_n, down_n = FORCE_RAMP_UP_N_S * TICK_S, FORCE_FALL_N_S * TICK_S
            assert -down_n - law_n - 1e-9 <= rig.force_n - before_n <= up_n + law_n + 1e-9
    assert rig.produced_j <= PRODUCED_J + 1e-4
