"""Local model: the remote site identifies surface and stiffness, and the operator site renders the force from them."""

from collections.abc import Callable

import numpy as np

from operator_site.force.passive_contact import PassiveContact
from operator_site.safety.sampled_wall import SampledWall
from operator_site.thermal.contact_prediction import ContactPrediction
from remote_site.stiffness.surface_estimate import SurfaceEstimate
from studies.teleoperation_stability.blended_contact import BlendedContact
from studies.teleoperation_stability.cases import DEVICE_NS_M, Floats, Measured

WALL_Z_M = 0.003
"""Height of the wall, m; above the surface height assumed before first contact, so the finger enters it unwarned."""


def passive(period_s: float) -> Callable[[], PassiveContact]:
    """Return the operator site's contact, which takes new models passively and stays displayable by the device."""
    return lambda: PassiveContact(SampledWall(DEVICE_NS_M, period_s))


class LocalModel:
    """Local model with one contact and one identification per run; height z is WALL_Z_M minus depth."""

    packet_rows = 3

    def __init__(
        self, start_m: Floats, period_s: float, contact: Callable[[], PassiveContact | BlendedContact]
    ) -> None:
        self._start_m, self._period_s, self._tick = start_m, period_s, 0
        self._contacts = [contact() for _ in start_m]
        self._approaches = [ContactPrediction() for _ in start_m]
        self._identified = [SurfaceEstimate() for _ in start_m]

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """Show the force of the newest model; send the position."""
        t_s = self._tick * self._period_s
        self._tick += 1
        heights = (WALL_Z_M - depth_m).tolist()
        force = [
            contact.step(t_s, z_m, surface_m, stiffness_n_m, damping_n_s_m, approach.step(t_s, z_m))
            for contact, approach, z_m, (surface_m, stiffness_n_m, damping_n_s_m) in zip(
                self._contacts, self._approaches, heights, packet.T.tolist(), strict=True
            )
        ]
        return np.array(force), (depth_m - self._start_m)[None].repeat(self.packet_rows, axis=0)

    def remote(self, at: Measured, packet: Floats) -> tuple[Floats, Floats, Floats]:
        """Go to the newest position, identify the surface, and send the model."""
        t_s = self._tick * self._period_s
        sensed = zip(self._identified, at.force_n.tolist(), (WALL_Z_M - at.depth_m).tolist(), strict=True)
        for identified, newton, z_m in sensed:
            identified.step(t_s, newton, 0.0, 0.0, z_m)
        model = np.array([(each.surface_z_m, each.stiffness_n_m, each.damping_n_s_m) for each in self._identified]).T
        return self._start_m + packet[0], 0.0 * at.force_n, model
