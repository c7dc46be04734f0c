"""What a texture sensor makes of a surface: leak, viscosity, force, speed and noise, fitted in calibration."""

import math
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from remote_site.texture.tip_path import LEAK_HZ

NOMINAL_FORCE_N = 1.0
NOMINAL_SPEED_M_S = 0.050
"""Roughness is stated for this force and speed."""
LEAST_FORCE_N = 0.15
LEAST_SPEED_M_S = 2e-3
"""Smaller ones count as these: a surface is not infinitely rough because a finger hardly touches it."""


class TextureLaw(BaseModel):
    """curvature = roughness * force^a * speed^b at nominal units, once the contact's viscosity is undone, and noise.

    Attributes:
        leak_hz: corner of the sensor's leaky integrator, Hz; 0 for a sensor that holds a constant force.
        viscous_s: time constant tau of the contact: it answers force plus tau times its rate of change, s.
        force_exponent: a.
        speed_exponent: b, what viscosity leaves over.
        noise_v: white noise of a sample, rms, V.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    leak_hz: Annotated[float, Field(ge=0.0, le=50.0, allow_inf_nan=False)] = LEAK_HZ
    viscous_s: Annotated[float, Field(ge=0.0, le=0.02, allow_inf_nan=False)] = 0.001
    force_exponent: Annotated[float, Field(ge=0.0, le=2.0, allow_inf_nan=False)] = 1.0
    speed_exponent: Annotated[float, Field(ge=-2.0, le=2.0, allow_inf_nan=False)] = 0.0
    noise_v: Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)] = 0.008

    def gain(self, force_n: float, speed_m_s: float) -> float:
        """Curvature per roughness at this force and speed."""
        return float(
            (max(force_n, LEAST_FORCE_N) / NOMINAL_FORCE_N) ** self.force_exponent
            * (max(speed_m_s, LEAST_SPEED_M_S) / NOMINAL_SPEED_M_S) ** self.speed_exponent
        )


def ln_roughness(roughness_v: float) -> float:
    """Logarithm of a roughness; nothing is smoother than 10 uV."""
    return math.log(max(roughness_v, 1e-5))
