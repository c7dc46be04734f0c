"""Law of a texture sensor, fitted in calibration: leak, viscosity, noise, and exponents of force and speed."""

import math
from typing import Annotated

from pydantic import Field

from common.files.strict_model import StrictModel
from remote_site.texture.tip_path import LEAK_HZ

NOMINAL_FORCE_N = 1.0
"""Force for which roughness is stated, N."""
NOMINAL_SPEED_M_S = 0.050
"""Speed for which roughness is stated, m/s."""
LEAST_FORCE_N = 0.15
"""Smallest force in the law, N; it keeps the roughness finite when a finger hardly touches."""
LEAST_SPEED_M_S = 2e-3
"""Smallest speed in the law, m/s; it keeps the roughness finite when a finger hardly moves."""


class TextureLaw(StrictModel):
    """curvature = roughness * force^a * speed^b in nominal units, plus noise, after the contact's viscosity is undone.

    Attributes:
        leak_hz: corner of the sensor's leaky integrator, Hz; 0 for a sensor that holds a constant force.
        viscous_s: time constant tau of the contact, s; it responds to the force plus tau times its rate of change.
        force_exponent: exponent a.
        speed_exponent: exponent b, the dependence on speed that viscosity does not explain.
        noise_v: white noise of a sample, rms, V.
    """

    leak_hz: Annotated[float, Field(ge=0.0, le=50.0)] = LEAK_HZ
    viscous_s: Annotated[float, Field(ge=0.0, le=0.02)] = 0.001
    force_exponent: Annotated[float, Field(ge=0.0, le=2.0)] = 1.0
    speed_exponent: Annotated[float, Field(ge=-2.0, le=2.0)] = 0.0
    noise_v: Annotated[float, Field(ge=0.0, le=1.0)] = 0.008

    def gain(self, force_n: float, speed_m_s: float) -> float:
        """Return curvature over roughness at this force and speed."""
        return float(
            (max(force_n, LEAST_FORCE_N) / NOMINAL_FORCE_N) ** self.force_exponent
            * (max(speed_m_s, LEAST_SPEED_M_S) / NOMINAL_SPEED_M_S) ** self.speed_exponent
        )


def ln_roughness(roughness_v: float) -> float:
    """Return the logarithm of a roughness in V; the smallest roughness is 10 uV."""
    return math.log(max(roughness_v, 1e-5))
