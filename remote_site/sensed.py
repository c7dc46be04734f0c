"""What the remote site's devices said in one tick: the exact input of identification, recorded and replayed."""

from dataclasses import dataclass

import msgpack

from common.recorded_fields import Fits, five, maybe, number, read_row, real, row, samples, text, whole
from remote_site.followed_hand import HandPlace
from remote_site.thermal_sensor import PlateReading

SCHEMA: dict[str, object] = {
    "type": "array",
    "description": "[time_s, x_m, y_m, z_m x 5, force_n x 5, texture counts x 5 (int16 little endian or null), "
    "plates x 5 ([sensor_c, ambient_c, fault, device_us, heater_permille] or null), hand ([source time of "
    "the motion that is followed, x_m, y_m] or null)]",
}

_pack = msgpack.Packer().pack
_FIELDS: dict[str, Fits] = {
    "time_s": number,
    "x_m": real,
    "y_m": real,
    "z_m": five(real),
    "force_n": five(real),
    "texture": five(maybe(samples)),
    "plates": five(maybe(row(real, real, text, whole, whole))),
    "hand": maybe(row(whole, real, real)),
}


@dataclass(slots=True)
class Sensed:
    """One tick's readings, five fingers each; None where nothing new came."""

    time_s: float
    x_m: float
    y_m: float
    z_m: tuple[float, ...]
    force_n: tuple[float, ...]
    texture_counts: tuple[bytes | None, ...]
    plates: tuple[PlateReading | None, ...]
    hand: HandPlace | None = None
    """The operator's hand that the fingers follow."""

    def pack(self) -> bytes:
        """Bytes for the recording; nothing is rounded."""
        plates = [
            None if p is None else [p.sensor_c, p.ambient_c, p.fault, p.device_us, p.heater_permille]
            for p in self.plates
        ]
        packed: bytes = _pack(
            [self.time_s, self.x_m, self.y_m, self.z_m, self.force_n, self.texture_counts, plates, self.hand]
        )
        return packed

    @classmethod
    def unpack(cls, packed: bytes) -> "Sensed":
        """Read what `pack` wrote.

        Raises:
            ValueError: it is something else.
        """
        try:
            time_s, x_m, y_m, z_m, force_n, texture, plates, hand = read_row(packed, _FIELDS)
        except ValueError as error:
            raise ValueError(f"not a record of sensed values, or one of an earlier version: {error}") from None
        return cls(
            time_s,
            x_m,
            y_m,
            tuple(z_m),
            tuple(force_n),
            tuple(texture),
            tuple(None if plate is None else PlateReading(*plate) for plate in plates),
            None if hand is None else HandPlace(*hand),
        )
