"""Places of a scene where the simulated patient is tender."""

from pydantic import Field

from common.files.strict_model import StrictModel


class TenderSpot(StrictModel):
    """A place where the patient's pain threshold is lowest; it rises to `surround_n` with the distance.

    Attributes:
        x_m, y_m: its centre on the bench, m.
        threshold_n: threshold at the centre, N.
        surround_n: threshold far from it, N.
        width_m: distance at which 39 % of the rise is reached, m.
    """

    x_m: float
    y_m: float
    threshold_n: float = Field(gt=0.0, le=20.0)
    surround_n: float = Field(gt=0.0, le=100.0)
    width_m: float = Field(gt=0.001, le=0.2)
