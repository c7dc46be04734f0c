"""The calibrated look-up table of thermal identification.

A touch is linear in the temperatures: the plate's drop is D g(t) + (T_obj - T_ambient) l(t) with
D = T_sensor(0) - T_obj. The gain g belongs to material, contact and sensor; l is what leaks past an object
that is not at ambient temperature, and follows from g (`drift`). The table holds mean and covariance of g
over calibration touches of each material, so that no physical model of the sensor is assumed, and the rate of
Eq. 11 at the same times for the paper's own method.
"""

from collections.abc import Sequence
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from remote_site.stored_table import StoredTable

TIMES_S = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)
"""Times after contact at which a touch is judged, s."""


def drift(gain: NDArray[np.float64], times_s: Sequence[float], leak_per_s: float) -> NDArray[np.float64]:
    """Drop at each time per kelvin of object above ambient: leak * integral of (1 - g).

    The plate in contact keeps the part 1 - g of any heat put into it, hence of each moment's leak.

    Args:
        gain: g at `times_s`, along the last axis; g(0) = 0.
        times_s: times after contact, s.
        leak_per_s: rate at which the free plate drifts to ambient, 1/s.
    """
    kept = 1.0 - np.concatenate((np.zeros((*gain.shape[:-1], 1)), gain), axis=-1)
    steps_s = np.diff(np.concatenate(((0.0,), times_s)))
    return leak_per_s * np.cumsum(0.5 * (kept[..., 1:] + kept[..., :-1]) * steps_s, axis=-1)


Finite = Annotated[float, Field(allow_inf_nan=False)]


class MaterialEntry(BaseModel):
    """One material as this sensor meets it; lists run over the table's times.

    Attributes:
        name: label given in calibration.
        touches: calibration touches behind the figures.
        gain_mean: mean of g, drop per kelvin of difference.
        gain_covariance: covariance of g over touches, times x times.
        ln_rate: mean of ln(rate of Eq. 11 in 1/s).
        ln_rate_sd: its standard deviation over touches.
        object_bias_k: mean of Eq. 11's object temperature minus the true one, K.
        offset_k: mean of object minus ambient temperature, K: the prior.
        offset_sd_k: its standard deviation, K.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(min_length=1)
    touches: int = Field(ge=2)
    gain_mean: list[Finite]
    gain_covariance: list[list[Finite]]
    ln_rate: list[Finite]
    ln_rate_sd: list[Finite]
    object_bias_k: list[Finite]
    offset_k: Finite
    offset_sd_k: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


class MaterialTable(StoredTable):
    """All calibrated materials of one sensor (or kind of sensor).

    Attributes:
        ambient_c: mean ambient temperature in calibration, C; stands in where a touch has none.
        leak_per_s: rate at which the free plate drifts to ambient, 1/s.
        noise_k: white noise of one averaged drop, K.
        times_s: times of judgement after contact, s, ascending.
        materials: two or more.
    """

    kind: Literal["thermal_materials"] = "thermal_materials"
    schema_version: Literal[1] = 1
    ambient_c: Finite
    leak_per_s: Annotated[float, Field(ge=0.0, lt=1.0)]
    noise_k: Annotated[float, Field(gt=0.0, lt=1.0)]
    times_s: list[Annotated[float, Field(gt=0.0, allow_inf_nan=False)]]
    materials: list[MaterialEntry] = Field(min_length=2)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        n = len(self.times_s)
        if n == 0 or any(b <= a for a, b in zip(self.times_s, self.times_s[1:], strict=False)):
            raise ValueError("times_s must ascend")
        if len({entry.name for entry in self.materials}) != len(self.materials):
            raise ValueError("a material is listed twice")
        for entry in self.materials:
            lists = (entry.gain_mean, entry.ln_rate, entry.ln_rate_sd, entry.object_bias_k, *entry.gain_covariance)
            if len(entry.gain_covariance) != n or any(len(values) != n for values in lists):
                raise ValueError(f"{entry.name}: every list needs one value per time")
            covariance = np.array(entry.gain_covariance)
            if not np.allclose(covariance, covariance.T) or np.linalg.eigvalsh(covariance)[0] <= 0.0:
                raise ValueError(f"{entry.name}: gain_covariance is no covariance")
        return self

    def names(self) -> list[str]:
        """Labels of the calibrated materials, in the table's order."""
        return [entry.name for entry in self.materials]
