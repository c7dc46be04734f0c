"""Table of calibrated surfaces with the constants for vibration rendering (Kron & Schmidt 2003, section 4.1).

The paper divides the mean rectified signal into hard intervals. Here roughness is a property of the surface, whatever
force and speed are. The constants are interpolated between calibrated surfaces, so that they never jump.
"""

import math
from dataclasses import dataclass
from typing import Literal

from pydantic import Field

from common.files.strict_model import StrictModel
from common.scenes.surfaces import surface_kind
from remote_site.tables.table_file import NotNegative, Positive, TableFile
from remote_site.texture.motion_spectrum import MotionSpectra
from remote_site.texture.roughness_scale import RoughnessScale
from remote_site.texture.texture_law import TextureLaw

ONE_ROUGHNESS = 0.25
"""Difference in ln(roughness) below which surfaces count as equally rough; a finger does not resolve a quarter."""
_ORDINARY = surface_kind("plain_pvc")
TAP_SPEED_PER_M_S, TAP_DECAY_PER_S = _ORDINARY.k_tap, _ORDINARY.b_tap_per_s
"""Constants k_tap and b_tap (1/s) of Eq. 1; constant as in the paper, because a tap is too short for identification."""
_GROOVED = surface_kind("closely_grooved_pvc").grooves
assert _GROOVED is not None
GROOVE_RAD_S, GROOVE_DECAY_PER_S = _GROOVED.impulse_rad_s, _GROOVED.decay_per_s
"""Amplitude, rad/s, and decay rate, 1/s, of the damped impulse J(t) of a groove as deep as the calibrated ones."""


class Surface(StrictModel):
    """One calibrated surface.

    Attributes:
        name: label given in calibration.
        ln_roughness: mean of ln(roughness in V); roughness is the rms curvature for one newton.
        ln_roughness_sd: standard deviation of ln(roughness).
        period_mm: mean spacing of grooves, mm; None for a surface without grooves.
        irregularity: standard deviation of the spacing over its mean.
        k_stroke_v: constant K_v,s of Eq. 2, (rad/s)/(m/s).
        k_stroke_f: constant K_F,s of Eq. 2, (rad/s)/N.
    """

    name: str = Field(min_length=1)
    ln_roughness: float
    ln_roughness_sd: Positive
    period_mm: Positive | None = None
    irregularity: NotNegative = 0.0
    k_stroke_v: Positive
    k_stroke_f: Positive


class SurfaceTable(TableFile):
    """Calibrated surfaces of one texture sensor.

    Attributes:
        law: law of the sensor.
        groove_v: curvature for one newton of the calibrated grooves, V; None if none was calibrated.
        surfaces: the calibrated surfaces.
        roughness_scale: roughness in um of a roughness in V; None if no surface of known roughness was calibrated.
        spectra: spectra of the surfaces, in their order, for recorded strokes; None where roughness and grooves
            recognised as many of the calibration's strokes.
    """

    kind: Literal["texture_surfaces"] = "texture_surfaces"
    schema_version: Literal[2, 3] = 3
    law: TextureLaw = TextureLaw()
    groove_v: Positive | None = None
    surfaces: list[Surface] = Field(min_length=1)
    roughness_scale: RoughnessScale | None = None
    spectra: MotionSpectra | None = None


@dataclass(frozen=True, slots=True)
class StrokeConstants:
    """Constants of Eq. 2, (rad/s)/(m/s) and (rad/s)/N."""

    k_stroke_v: float
    k_stroke_f: float


SMOOTH = StrokeConstants(0.0, 0.0)
"""Constants of a surface without vibration."""


class StrokeLaw:
    """Interpolates ln K_v,s and ln K_F,s between the calibrated surfaces, linearly in ln(roughness).

    Surfaces closer than ONE_ROUGHNESS count as one, with the mean of their constants. Beyond the smoothest and the
    roughest surface, the constants of these are used.
    """

    def __init__(self, table: SurfaceTable) -> None:
        groups: list[list[Surface]] = []
        for surface in sorted(table.surfaces, key=lambda surface: surface.ln_roughness):
            if groups and surface.ln_roughness - groups[-1][0].ln_roughness < ONE_ROUGHNESS:
                groups[-1].append(surface)
            else:
                groups.append([surface])
        self._centres = [_centre(group) for group in groups]

    def at(self, ln_roughness: float) -> StrokeConstants:
        """Return the constants of a surface with this ln(roughness in V)."""
        low = high = self._centres[0]
        for centre in self._centres:
            low, high = high, centre
            if high[0] >= ln_roughness:
                break
        else:
            low = high
        part = (ln_roughness - low[0]) / (high[0] - low[0]) if high[0] > low[0] else 0.0
        part = min(max(part, 0.0), 1.0)
        k_v, k_f = low[1] + part * (high[1] - low[1]), low[2] + part * (high[2] - low[2])
        return StrokeConstants(math.exp(k_v), math.exp(k_f))


def _centre(group: list[Surface]) -> tuple[float, float, float]:
    """Return the means of ln(roughness), ln K_v,s and ln K_F,s."""
    n = len(group)
    return (
        sum(surface.ln_roughness for surface in group) / n,
        sum(math.log(surface.k_stroke_v) for surface in group) / n,
        sum(math.log(surface.k_stroke_f) for surface in group) / n,
    )
