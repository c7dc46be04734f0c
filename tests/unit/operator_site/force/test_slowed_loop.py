"""A loop that works for 10 ms in every 40 holds each force longer: nothing that it shows may swing for that.

The finger is 0.1 kg on a spring of 400 N/m, in an exoskeleton of 2 Ns/m whose forces come 4 ms late.
"""

import math
from collections import deque

import numpy as np
import pytest
from msgspec.structs import replace

from common.config.site_models import RenderingConfig
from common.wire.packets import N
from operator_site.gated_rendering import GatedRendering
from operator_site.safety.limit_flags import Limit
from tests.unit.operator_site.touches import INDEX, tick_input, touch

TICK_S = 0.002
HARD = touch(contact=1, stiffness_n_m=2000.0)
PHYSICS = 20
"""Steps of the finger in a tick."""
LATE_TICKS = 2
SLICE, WORKED = 20, 5
"""Ticks of 40 ms, and those of them that a slowed loop does."""


class Finger:
    """An index finger meant to be so deep in a hard surface at 0, with a tremor, and the loop that renders to it."""

    def __init__(self, deep_m: float) -> None:
        self.rendering = GatedRendering(RenderingConfig(), TICK_S, 0.1)
        self.tick, self.z_m, self.speed_m_s = 0, -deep_m, 0.0
        self.deep_m = deep_m
        self.pushed = deque([0.0] * LATE_TICKS, maxlen=LATE_TICKS)
        self.force_n, self.limited = 0.0, 0
        self.given = tick_input(plate_c=(math.nan,) * N, plate_age_s=(math.inf,) * N)

    def run(self, seconds: float, *, slowed: bool = False, engaged: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Heights and forces of each tick for some time, m and N."""
        course = []
        for n in range(round(seconds / TICK_S)):
            if not slowed or n % SLICE < WORKED:
                self._render(engaged)
            self._move()
            course.append((self.z_m, self.force_n))
        z_m, force_n = np.array(course).T
        return z_m, force_n

    def _render(self, engaged: bool) -> None:
        t_s = 1.0 + self.tick * TICK_S
        heights = tuple(round(self.z_m, 5) if finger == INDEX else 0.01 for finger in range(N))
        now = replace(self.given, time_s=t_s, pose_s=t_s, heights_s=t_s, z_m=heights, engaged=engaged)
        output = self.rendering.step(now, HARD)
        assert output.fault is None, output.fault
        self.force_n, self.limited = output.force_n[INDEX], self.limited | output.limited[INDEX]

    def _move(self) -> None:
        pushed_n = self.pushed.popleft()
        self.pushed.append(self.force_n)
        for _ in range(PHYSICS):
            meant_m = -self.deep_m + 20e-6 * math.sin(2.0 * math.pi * 9.0 * self.tick * TICK_S)
            pull_n = 400.0 * (meant_m - self.z_m) - 4.0 * self.speed_m_s + pushed_n
            self.speed_m_s += TICK_S / PHYSICS * pull_n / 0.1
            self.z_m += TICK_S / PHYSICS * self.speed_m_s
        self.tick += 1


@pytest.mark.parametrize("deep_m", [0.003, 0.005, 0.008])
def test_a_finger_with_debt_does_not_swing_and_later_feels_the_same(deep_m: float) -> None:
    """It lay in the surface when outputs began to act: what holds it is lent; the port's guard limits it."""
    finger = Finger(deep_m)
    finger.run(0.2, engaged=False)
    _, before_n = finger.run(1.0)
    z_m, during_n = finger.run(3.0, slowed=True)
    assert finger.limited & Limit.PASSIVITY, "the energy of the port is what limits here"
    assert np.ptp(z_m[-500:]) < 0.2e-3
    assert during_n[-500:].min() > 0.4 * before_n[-1]
    _, after_n = finger.run(1.0)
    assert after_n[-1] > 0.8 * before_n[-1]


def test_a_slow_loop_displays_the_wall_of_its_period() -> None:
    """A finger that presses again feels the softer spring, and `stiffness` is reported."""
    rendering, slow_s, t_s = GatedRendering(RenderingConfig(), TICK_S, 0.1), 0.010, 1.0

    def press(depth_m: float, ticks: int) -> float:
        nonlocal t_s
        for n in range(ticks):
            t_s += slow_s
            z_m = 0.001 - (0.001 + depth_m) * (n + 1) / ticks
            now = tick_input(time_s=t_s, pose_s=t_s, heights_s=t_s, z_m=(z_m,) * N, plate_age_s=(math.inf,) * N)
            output = rendering.step(now, HARD)
        assert output.limited[INDEX] & Limit.STIFFNESS
        assert not output.limited[INDEX] & Limit.PASSIVITY
        return output.force_n[INDEX]

    press(0.0, 200)
    assert press(0.003, 100) == pytest.approx(0.003 * rendering.wall.stiffest_n_m, rel=0.01)
    assert rendering.wall.stiffest_n_m == pytest.approx(2.0 / (0.5 * slow_s + 0.004), rel=0.01)
