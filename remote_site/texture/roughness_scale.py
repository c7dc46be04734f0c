"""Converts a roughness in V to one in um; surfaces of known roughness calibrate the scale."""

import math

from common.files.strict_model import StrictModel
from common.wire.roughness_um import RoughnessUm
from remote_site.tables.table_file import Positive


class RoughnessScale(StrictModel):
    """ln(roughness in um) = ln_um + exponent * ln(roughness in V).

    Attributes:
        ln_um: ln(roughness in um) at 1 V.
        exponent: exponent of the roughness in V.
        ln_sd: standard deviation of ln(roughness in um) of one stroke.
        least_v: smallest calibrated roughness, V.
        most_v: largest calibrated roughness, V.
    """

    ln_um: float
    exponent: Positive
    ln_sd: Positive
    least_v: Positive
    most_v: Positive

    def at(self, roughness_v: float) -> tuple[float, float] | None:
        """Return a roughness and its standard deviation, um; None outside of the calibrated range."""
        if not RoughnessUm(**self.model_dump()).holds(roughness_v):
            return None
        roughness_um = math.exp(self.ln_um + self.exponent * math.log(roughness_v))
        return roughness_um, roughness_um * self.ln_sd
