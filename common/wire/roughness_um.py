"""Scale of roughness in um, which a calibrated remote site sends with its capabilities."""

from collections.abc import Mapping
from typing import NamedTuple, Self


class RoughnessUm(NamedTuple):
    """ln(roughness in um) = ln_um + exponent ln(roughness in V), with a standard deviation of ln_sd."""

    ln_um: float
    exponent: float
    ln_sd: float

    @classmethod
    def of(cls, received: object) -> Self | None:
        """Return the scale in a message or a status; None if there is none, or one that is no scale."""
        if not isinstance(received, Mapping):
            return None
        values = [received.get(name) for name in cls._fields]
        numbers = [float(value) for value in values if isinstance(value, (int, float)) and abs(value) < 100.0]
        return cls(*numbers) if len(numbers) == len(values) and numbers[1] > 0.0 and numbers[2] > 0.0 else None
