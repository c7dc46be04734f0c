"""Simulate a person's hand in the exoskeleton that follows a scene's script.

Along the bench, the hand is at the planned position plus tremor. Each fingertip is a mass on the finger's own
spring and damper (Hajian & Howe 1997). The spring pulls it to the wanted height and the exoskeleton pushes it up.
The exoskeleton adds mass and friction of its own:

    m z'' = k (z_wanted - z) + b (z_wanted' - z') - b_exoskeleton z' + F_exoskeleton
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from common.fingers import FINGERS
from common.scenes.scene import Scene
from sim_sensors.operator_hand.hand_plan import FREE, HOVER_M, LIFT_S, HandPlan, Segment, Wanted, minimum_jerk

MASS_KG = 0.1
"""Mass of the finger and the exoskeleton's link, kg."""
FINGER_DAMPING_N_S_M = 2.0
EXOSKELETON_DAMPING_N_S_M = 2.0
FINGER_STIFFNESS_N_M = 400.0
HIGHEST_M = 0.0100
"""Upper mechanical stop of the exoskeleton's fingers, m."""
LOWEST_M = -0.0100
"""Lower mechanical stop of the exoskeleton's fingers, m."""
STOP_S = 0.15
"""Time in which the arm comes to rest after `finish`, s."""

TREMOR_HZ = (8.0, 11.0)
TREMOR_XY_M = 0.015e-3
TREMOR_Z_M = 0.02e-3
DRIFT_HZ = (0.15, 0.4)
DRIFT_M = 0.1e-3


class ScriptedHand:
    """Hand of the simulated operator.

    It hovers over the first object until `start`, repeats the script, and lifts and stays after `finish`.

    Attributes:
        time_s: time since the hand was made, s.
        script_s: script time executed, s.
        x_m, y_m: position of the hand.
        z_m, heights_m: heights of the fingertips over the bench plane, as array and list of five, negative below it.
        mode: exploration mode that the script intends now (0 free .. 3 stroking).
        segment: present movement of the script.
    """

    def __init__(self, scene: Scene, *, seed: int, fingers: Sequence[str] = FINGERS) -> None:
        """Prepare the first pass through the scene's script; only `fingers` will touch, the others stay up."""
        self._scene = scene
        self._used = np.array([finger in fingers for finger in FINGERS])
        self._rng = np.random.default_rng([seed, 0x4A4D])
        self._plan = HandPlan(self._scene, self._used, self._rng)
        self._first_seconds = self._plan.seconds
        self._plan_began_s = 0.0
        count = len(FINGERS)
        hz = [self._rng.uniform(*band, count + 2) for band in (TREMOR_HZ, DRIFT_HZ)]
        self._tremble_rad_s = 2.0 * math.pi * np.array(hz)
        self._phase = self._rng.uniform(0.0, 2.0 * math.pi, (2, count + 2))
        self._tremor_m = [TREMOR_XY_M] * 2 + [TREMOR_Z_M] * count
        self._advance = np.empty((2, 2))
        self._push = np.empty((2, 3))
        self._advance_dt_s = 0.0
        self._working_since_s: float | None = None
        self._finished_at_s: float | None = None
        self.time_s = 0.0
        self.script_s = 0.0
        wanted = self._plan.at(0.0)
        self._wanted_z = wanted.z_m.tolist()
        self._motion: NDArray[np.float64] = np.stack((wanted.z_m, np.zeros(count)))
        self.heights_m = _within_stops(self._motion)
        self._follow(wanted)

    @property
    def z_m(self) -> NDArray[np.float64]:
        """Heights of the fingertips, (5,), within the exoskeleton's stops."""
        return np.array(self.heights_m)

    def total_seconds(self) -> float:
        """Return the duration of the first pass through the script, s."""
        return self._first_seconds

    def timeline(self) -> list[Segment]:
        """Return the movements of the present pass; their times count from its start."""
        return list(self._plan.segments)

    @property
    def finished(self) -> bool:
        """Whether `finish` was called."""
        return self._finished_at_s is not None

    def start(self) -> None:
        """Begin the script (once; later calls do nothing)."""
        if self._working_since_s is None:
            self._working_since_s = self.time_s

    def finish(self) -> None:
        """End the script: stop, lift and hover."""
        if self._finished_at_s is None:
            self._finished_at_s = self.time_s

    def step(self, dt_s: float, force_n: NDArray[np.float64]) -> None:
        """Advance by `dt_s` while the exoskeleton pushes the fingers up with `force_n`, (5,), N."""
        self.time_s += dt_s
        self.script_s += dt_s * self._pace()
        if self.script_s - self._plan_began_s >= self._plan.seconds:
            self._plan_began_s += self._plan.seconds
            self._plan = HandPlan(self._scene, self._used, self._rng, self._plan.end)
        wanted = self._plan.at(self.script_s - self._plan_began_s)
        _, _, *tremble = self._follow(wanted)
        wanted_z = [z + by for z, by in zip(self._lifted(wanted.z_m).tolist(), tremble, strict=True)]
        if dt_s != self._advance_dt_s:
            self._prepare(dt_s)
        middle, speed = [], []
        for now, before in zip(wanted_z, self._wanted_z, strict=True):
            middle.append(0.5 * (now + before))
            speed.append((now - before) / dt_s)
        self._motion = self._advance @ self._motion + self._push @ np.array((middle, speed, force_n.tolist()))
        self._wanted_z = wanted_z
        self.heights_m = _within_stops(self._motion)

    def _follow(self, wanted: Wanted) -> list[float]:
        """Move the hand to the wanted position; return the tremor of x, y and each finger's height, m."""
        tremble = self._tremble()
        self.x_m, self.y_m = wanted.x_m + tremble[0], wanted.y_m + tremble[1]
        self.segment = wanted.segment
        self.mode = FREE if self._finished_at_s is not None or self._working_since_s is None else wanted.mode
        return tremble

    def _pace(self) -> float:
        """Return the rate of script time: 0 before `start`, then 1, falling smoothly to 0 after `finish`."""
        if self._working_since_s is None:
            return 0.0
        if self._finished_at_s is None:
            return 1.0
        return 1.0 - minimum_jerk((self.time_s - self._finished_at_s) / STOP_S)

    def _lifted(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._finished_at_s is None:
            return z_m
        return z_m + (HOVER_M - z_m) * minimum_jerk((self.time_s - self._finished_at_s) / LIFT_S)

    def _tremble(self) -> list[float]:
        fast, slow = np.sin(self._tremble_rad_s * self.time_s + self._phase).tolist()
        return [m * up + DRIFT_M * away for m, up, away in zip(self._tremor_m, fast, slow, strict=True)]

    def _prepare(self, dt_s: float) -> None:
        """Solve the finger's equation exactly over one step of constant input (van Loan 1978)."""
        stiffness, damping = FINGER_STIFFNESS_N_M / MASS_KG, FINGER_DAMPING_N_S_M / MASS_KG
        friction = EXOSKELETON_DAMPING_N_S_M / MASS_KG
        augmented = np.zeros((5, 5))
        augmented[0, 1] = 1.0
        augmented[1] = (-stiffness, -damping - friction, stiffness, damping, 1.0 / MASS_KG)
        solved = expm(augmented * dt_s)
        self._advance, self._push, self._advance_dt_s = solved[:2, :2], solved[:2, 2:], dt_s


def _within_stops(motion: NDArray[np.float64]) -> list[float]:
    """Return the heights of the fingers, limited by the exoskeleton's stops, m."""
    return [min(max(z_m, LOWEST_M), HIGHEST_M) for z_m in motion[0].tolist()]
