"""Scale of roughness in um, which a calibrated remote site sends with its capabilities."""

import math
from collections.abc import Mapping
from typing import NamedTuple, Self

BEYOND_LN = 0.25
"""Distance in ln(roughness in V) beyond the calibrated range up to which a scale holds."""


class RoughnessUm(NamedTuple):
    """ln(roughness in um) = ln_um + exponent ln(roughness in V), with a standard deviation of ln_sd.

    Calibrated from least_v to most_v, V. Older sites do not send this range: their scale holds for every roughness.
    """

    ln_um: float
    exponent: float
    ln_sd: float
    least_v: float = 0.0
    most_v: float = 100.0

    @classmethod
    def of(cls, received: object) -> Self | None:
        """Return the scale in a message or a status; None if there is none, or one that is no scale."""
        if not isinstance(received, Mapping):
            return None
        values = [received.get(name, cls._field_defaults.get(name)) for name in cls._fields]
        numbers = [float(value) for value in values if isinstance(value, (int, float)) and abs(value) <= 100.0]
        if len(numbers) < len(values):
            return None
        scale = cls(*numbers)
        sound = scale.exponent > 0.0 and scale.ln_sd > 0.0 and 0.0 <= scale.least_v <= scale.most_v
        return scale if sound else None

    @property
    def holds_v(self) -> tuple[float, float]:
        """Smallest and largest roughness of which the scale holds, V."""
        beyond = math.exp(BEYOND_LN)
        return self.least_v / beyond, self.most_v * beyond

    def holds(self, roughness_v: float) -> bool:
        """Return whether the scale holds for a roughness, V."""
        least_v, most_v = self.holds_v
        return least_v <= roughness_v <= most_v
