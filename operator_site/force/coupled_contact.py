"""Contact of one finger of a hand that is coupled by clutch and motion scale.

The model of the surface is in remote units. The hand moves `scale` times as far as the remote finger, and force is
displayed one to one. So the hand's own spring has the stiffness k / scale and the damping b / scale, and its surface is
where the command reaches the remote surface. `PassiveContact` and the gate count energy at the hand itself.
"""

from collections.abc import Sequence

from common.fingers import FINGERS
from common.limits import COUPLING_RAMP_N_S, COUPLING_STEP_N, FINGER_FORCE_N, REMOTE_LOW_M
from operator_site.coupling.coupling import EDGE_HEIGHT_M, Coupling
from operator_site.force.passive_contact import PassiveContact
from operator_site.safety.sampled_wall import SampledWall

EDGE_N_M = 300.0
"""Stiffness of the soft wall before the lowest remote height, at the hand, N/m."""


class ForceCeiling:
    """Ceiling of all finger forces: it falls to 0 while the clutch is open, and rises again after it closes.

    Attributes:
        force_n: the ceiling, N.
    """

    def __init__(self) -> None:
        self.begin_session()

    def begin_session(self) -> None:
        """Begin above every force, because a session begins without force."""
        self._open, self.force_n = False, FINGER_FORCE_N

    @property
    def released(self) -> bool:
        """Whether the clutch is open and no force acts any more."""
        return self._open and self.force_n == 0.0

    def step(self, dt_s: float, is_open: bool, pushed_n: Sequence[float]) -> None:
        """Take the time since the last step, s, whether the clutch is open, and the force on each finger, N."""
        if is_open and not self._open:
            self.force_n = min(self.force_n, max(pushed_n))
        self._open = is_open
        change_n = min(COUPLING_STEP_N, COUPLING_RAMP_N_S * dt_s)
        self.force_n = max(0.0, self.force_n - change_n) if is_open else min(FINGER_FORCE_N, self.force_n + change_n)


class WorkspaceEdge:
    """Soft walls at each finger before the lowest height that the remote finger can reach."""

    def __init__(self, wall: SampledWall) -> None:
        self._walls = [PassiveContact(wall) for _ in FINGERS]

    def show(self, wall: SampledWall) -> None:
        """Set the bound of the displayed walls."""
        for each in self._walls:
            each.show(wall)

    def step(self, t_s: float, finger: int, z_m: float, coupling: Coupling, pushed_n: float, *, rests: bool) -> float:
        """Return the force of the wall on a finger of the hand, N.

        Args:
            t_s: time, s.
            finger: number of the finger.
            z_m: height of the hand's finger, m.
            coupling: the present coupling.
            pushed_n: force that was let through to the finger since the last step, N.
            rests: whether no force acts, because outputs rest or the clutch is open.
        """
        wall = self._walls[finger]
        edge_m = coupling.hand_height_m(finger, REMOTE_LOW_M + EDGE_HEIGHT_M)
        if z_m > edge_m + EDGE_HEIGHT_M and wall.force_n == 0.0:
            return 0.0  # far above it
        if wall.force_n > pushed_n:
            wall.let_through(pushed_n)
        if rests:
            wall.rest()
        return wall.step(t_s, z_m, edge_m, 0.0 if rests else EDGE_N_M)
