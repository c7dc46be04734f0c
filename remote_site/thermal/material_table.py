"""Thermal look-up table with the constants of one kind of sensor and its calibrated materials.

Readings show only ratios to the heat capacity of the sensor's plate. The table therefore holds effusivity and
conductance as such ratios; `plate_j_m2k` converts them to J/(m2 K s^0.5) and W/(m2 K) for display.
"""

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from common.files.strict_model import StrictModel
from common.wire.packets import MAX_TEXT
from remote_site.tables.table_file import Positive, TableFile
from remote_site.thermal.discrepancy import Discrepancy

RATE_TIMES_S = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)
"""Times after contact at which the paper's rate is tabulated, s."""


class MaterialEntry(StrictModel):
    """One material as measured by this sensor.

    Attributes:
        name: label given in calibration; packets carry it.
        touches: number of calibration touches.
        ln_effusivity: mean of ln(e / C''), e / C'' in 1/sqrt(s).
        ln_conductance: mean of ln(h / C'') at large force, h / C'' in 1/s.
        covariance: covariance of both from touch to touch.
        slab_s: thickness^2 / diffusivity of the pieces, s; None if their back has no effect.
        offset_k: mean of object minus ambient temperature, K; it serves as the prior.
        offset_sd_k: standard deviation of object minus ambient temperature, K.
        ln_rate: mean of ln(rate of Eq. 11 in 1/s) at the table's times.
        ln_rate_sd: standard deviation of that logarithm over touches.
        misfit: mean square of the model's residuals over the sensor's noise variance; 1 for a perfect fit.
    """

    name: str = Field(min_length=1, max_length=MAX_TEXT)
    touches: int = Field(ge=2)
    ln_effusivity: float
    ln_conductance: float
    covariance: list[list[float]]
    slab_s: Positive | None
    offset_k: float
    offset_sd_k: Positive
    ln_rate: list[float]
    ln_rate_sd: list[float]
    misfit: Positive

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if [len(row) for row in self.covariance] != [2, 2]:
            raise ValueError(f"{self.name}: covariance is no 2 x 2 covariance")
        c = np.array(self.covariance)
        if not np.allclose(c, c.T) or np.linalg.eigvalsh(c)[0] <= 0.0:
            raise ValueError(f"{self.name}: covariance is no 2 x 2 covariance")
        return self


class MaterialTable(TableFile):
    """All calibrated materials of one sensor (or kind of sensor).

    Attributes:
        ambient_c: mean ambient temperature in calibration, C; used for a touch without its own.
        plate_j_m2k: nominal heat capacity of the plate per area, J/(m2 K).
        leak_per_s: conductance from the plate into the Peltier's back, over the heat capacity, 1/s.
        half_force_n: force at which a contact conducts half as well as at large force, N.
        force_power: exponent of the force in the conductance of a light contact.
        early_s: time by which heat flows before the force shows contact, s; negative if it flows later.
        back_share: temperature of the back at contact, between ambient (0) and plate (1).
        back_sd_k: standard deviation of the back's temperature around that, K.
        start_sd_k: standard deviation of the plate at contact around the estimate from its reading and slope, K.
        ln_lag: mean of ln(lag of the read-out in s).
        ln_lag_sd: standard deviation of that logarithm from touch to touch.
        noise_k: white noise of one reading that the estimator must assume, K.
        times_s: times after contact of the rates, s, ascending.
        materials: calibrated materials, two or more.
        lasts_s: time after contact up to which calibration has tried the model; later readings are not used.
        discrepancy: what the model leaves out of this sensor's touches; None in a table that does not know it.
        reference: table of the unheated sensor beside this one, with the same materials; None without one.
    """

    kind: Literal["thermal_materials"] = "thermal_materials"
    schema_version: Literal[3, 4] = 4
    ambient_c: float
    plate_j_m2k: Positive
    leak_per_s: Annotated[float, Field(ge=0.0, lt=1.0)]
    half_force_n: Positive
    force_power: Positive
    early_s: Annotated[float, Field(gt=-0.2, lt=0.2)]
    back_share: float
    back_sd_k: Positive
    start_sd_k: Positive
    ln_lag: float
    ln_lag_sd: Positive
    noise_k: Annotated[float, Field(gt=0.0, lt=1.0)]
    times_s: list[Positive]
    materials: list[MaterialEntry] = Field(min_length=2)
    lasts_s: Positive = 8.0
    discrepancy: Discrepancy | None = None
    reference: "MaterialTable | None" = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        n = len(self.times_s)
        if n == 0 or any(b <= a for a, b in zip(self.times_s, self.times_s[1:], strict=False)):
            raise ValueError("times_s must ascend")
        if len({entry.name for entry in self.materials}) != len(self.materials):
            raise ValueError("a material is listed twice")
        for entry in self.materials:
            if len(entry.ln_rate) != n or len(entry.ln_rate_sd) != n:
                raise ValueError(f"{entry.name}: every list needs one value per time")
        if self.discrepancy is not None and len(self.discrepancy.by_plate[0]) != len(self.materials):
            raise ValueError("discrepancy: every row needs one value per material")
        return self

    def names(self) -> list[str]:
        """Labels of the calibrated materials, in the table's order."""
        return [entry.name for entry in self.materials]

    def described(self) -> str:
        """Return a line about the calibration for people: date, number of touches and scatter of single touches."""
        touches = sum(entry.touches for entry in self.materials)
        apart = math.sqrt(sum(entry.covariance[0][0] * entry.touches for entry in self.materials) / touches)
        return (
            f"Calibrated {self.made_on or 'at no known date'} (sensor {self.sensor_serial}), "
            f"{touches} touches, effusivity ± {100.0 * apart:.0f} %"
        )

    def effusivity(self, ln_effusivity: float) -> float:
        """Return the effusivity, J/(m2 K s^0.5), of a ln effusivity in the table's units."""
        return float(np.exp(ln_effusivity)) * self.plate_j_m2k
