"""Readings of all devices of the remote site in one tick: the exact input of identification, recorded and replayed."""

from collections.abc import Sequence
from typing import NamedTuple, Self

from msgspec import structs

from common.recording.recorded_row import Finite, FixedFive, Row, Whole
from common.wire.messages import THERMAL_REASONS, ThermalReason


class HandPlace(NamedTuple):
    """The operator's hand in a motion packet: source time on the operator's clock, ns, and place, m."""

    time_ns: Whole
    x_m: float
    y_m: float


class PlateReading(Row):
    """One reading of a thermal sensor.

    Attributes:
        sensor_c: plate, C.
        ambient_c: ambient, C.
        fault: code of the `ThermalReason` that makes the reading implausible; empty without one.
        device_us: time of the reading by the sensor's own clock, us modulo 2^32.
        heater_permille: drive of the heater at this time, thousandths of full drive.
    """

    sensor_c: float
    ambient_c: float
    fault: str
    device_us: Whole
    heater_permille: Whole

    @property
    def reason(self) -> ThermalReason:
        """Why the reading is implausible; NONE if it is plausible."""
        return THERMAL_REASONS[self.fault]


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
        """Read what `pack` wrote; raises ValueError where the payload is something else."""
        try:
            sensed = super().unpack(payload)
        except ValueError as error:
            raise ValueError(f"not a record of sensed values, or one of an earlier version: {error}") from None
        if any(counts is not None and len(counts) % 2 for counts in sensed.texture_counts):
            raise ValueError("not a record of sensed values: texture counts are not 16-bit numbers")
        if any(plate is not None and plate.fault not in THERMAL_REASONS for plate in sensed.plates):
            raise ValueError("not a record of sensed values: a plate's fault is no code of a thermal reason")
        return sensed


def with_sensors_in_doubt(sensed: SensorFrame, in_doubt: Sequence[bool]) -> SensorFrame:
    """Return readings of which those of some thermal sensors, (5,), are implausible."""
    code = ThermalReason.SENSOR_FROZEN.code
    plates = [
        structs.replace(plate, fault=plate.fault or code) if plate is not None and doubted else plate
        for plate, doubted in zip(sensed.plates, in_doubt, strict=True)
    ]
    return structs.replace(sensed, plates=tuple(plates))
