"""What the remote site's devices said in one tick: the exact input of identification, recorded and replayed."""

from typing import Self

from common.recording.recorded_row import Finite, FixedFive, Row
from common.wire.messages import THERMAL_REASONS
from remote_site.devices.hand_path import HandPlace
from remote_site.devices.thermal_sensor import PlateReading


class SensorFrame(Row):
    """One tick's readings, five fingers each; None where nothing new came."""

    time_s: Finite
    x_m: float
    y_m: float
    z_m: FixedFive[float]
    force_n: FixedFive[float]
    texture_counts: FixedFive[bytes | None]
    """16-bit numbers, little endian."""
    plates: FixedFive[PlateReading | None]
    hand: HandPlace | None
    """The operator's hand that the fingers follow."""

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read what `pack` wrote.

        Raises:
            ValueError: it is something else.
        """
        try:
            sensed = super().unpack(payload)
        except ValueError as error:
            raise ValueError(f"not a record of sensed values, or one of an earlier version: {error}") from None
        if any(counts is not None and len(counts) % 2 for counts in sensed.texture_counts):
            raise ValueError("not a record of sensed values: texture counts are not 16-bit numbers")
        if any(plate is not None and plate.fault not in THERMAL_REASONS for plate in sensed.plates):
            raise ValueError("not a record of sensed values: a plate's fault is no code of a thermal reason")
        return sensed
