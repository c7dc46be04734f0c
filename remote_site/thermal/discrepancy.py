"""Discrepancy of a sensor: the difference between estimates and truth that its calibration touches showed.

Every model of a touch leaves something out: a case that also cools the plate, a thermometer with two lags, heat that
flows sideways. Such an error changes slowly from touch to touch and grows with the temperatures around the plate:

    estimated - true object temperature = a (plate - ambient) + b (object - ambient) + rest,

with a and b for each material and time after contact. The variance of the rest is a multiple of the variance that the
estimate states, and a part that grows with the difference between plate and object. Calibration knows b only from its
own objects, so that the temperature of a colder or warmer one is less certain.
"""

from typing import Annotated, Self

from pydantic import Field, model_validator

from common.files.strict_model import StrictModel
from remote_site.tables.table_file import NotNegative, Positive

BY_TIME = ("times_s", "by_plate", "by_object", "by_object_sd", "spread", "stated_sd", "sharpness")
"""Fields with one value, or one row, for each time."""


class Discrepancy(StrictModel):
    """Discrepancy of one kind of sensor, by time after contact; lists of t values, or t lists of m materials.

    Attributes:
        times_s: times after contact, s, ascending; before the first and after the last, their values hold.
        plate_k: mean temperature of the plate above ambient at contact in calibration, K; m materials.
        coldest_k, warmest_k: range of the objects' temperatures above ambient in calibration, K; m materials.
        by_plate: error of the object's temperature per kelvin between plate and ambient.
        by_object: error of the object's temperature per kelvin between object and ambient.
        by_object_sd: standard deviation of `by_object`.
        spread: standard deviation of the rest per kelvin between plate and object.
        stated_sd: true standard deviation of the temperature over the one that the estimate states.
        sharpness: exponent of the likelihood of a material; below 1, the readings say less than the model believes.
        known_objects: whether calibration knew the temperatures of a material's objects; m materials.
    """

    times_s: list[Positive] = Field(min_length=1)
    plate_k: list[float]
    coldest_k: list[float]
    warmest_k: list[float]
    by_plate: list[list[float]]
    by_object: list[list[Annotated[float, Field(gt=-1.0)]]]
    by_object_sd: list[list[NotNegative]]
    spread: list[list[NotNegative]]
    stated_sd: list[Positive]
    sharpness: list[Positive]
    known_objects: list[bool]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        materials = len(self.by_plate[0]) if self.by_plate else 0
        if any(b <= a for a, b in zip(self.times_s, self.times_s[1:], strict=False)):
            raise ValueError("discrepancy: times_s must ascend")
        if any(len(getattr(self, name)) != len(self.times_s) for name in BY_TIME):
            raise ValueError("discrepancy: every list needs one value per time")
        rows: tuple[list[float] | list[bool], ...] = (
            self.plate_k,
            self.coldest_k,
            self.warmest_k,
            self.known_objects,
            *self.by_plate,
            *self.by_object,
            *self.by_object_sd,
            *self.spread,
        )
        if any(len(row) != materials for row in rows):
            raise ValueError("discrepancy: every row needs one value per material")
        return self
