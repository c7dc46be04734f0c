"""All that rendering depends on in one tick: the exact input of `Rendering`, recorded and replayed."""

from collections.abc import Callable
from dataclasses import dataclass

import msgpack

from common.limits import GAP_S
from common.messages import Touch
from common.recorded_fields import Fits, five, flag, maybe, number, read_row, real, texts, whole

SCHEMA: dict[str, object] = {
    "type": "array",
    "description": "[time_s, session, fault cleared, engaged, gap_ns or null, touch sequence or null, x_m, y_m, "
    "z_m x 5, pose_s, heights_s, plate_c x 5, plate age_s x 5, faults of modules]; the touch is "
    "the newest of operator/touch before it",
}

_pack = msgpack.Packer().pack
_FIELDS: dict[str, Fits] = {
    "time_s": number,
    "session": whole,
    "fault_cleared": flag,
    "engaged": flag,
    "gap_ns": maybe(whole),
    "touch": maybe(whole),
    "x_m": real,
    "y_m": real,
    "z_m": five(real),
    "pose_s": real,
    "heights_s": real,
    "plate_c": five(real),
    "plate_age_s": five(real),
    "device_faults": texts,
}


@dataclass(slots=True)
class RenderingInput:
    """One tick's input, five fingers each."""

    time_s: float
    session: int
    """Number of the session, 0 while there is none: events are numbered anew in each."""
    fault_cleared: bool
    """A person has cleared the fault since the last tick."""
    engaged: bool
    """Whether both sites say that outputs may act."""
    gap_ns: int | None
    """Since the last accepted touch packet; None before the first of the session."""
    touch: Touch | None
    """The newest accepted touch packet of the session, fresh or not."""
    x_m: float
    y_m: float
    z_m: tuple[float, ...]
    """Place of the hand and height of each fingertip."""
    pose_s: float
    heights_s: float
    """When place and heights were measured; -inf before the first measurement."""
    plate_c: tuple[float, ...]
    plate_age_s: tuple[float, ...]
    """Last reading of each plate, NaN where it is not to be believed, and its age, infinite where there was none."""
    device_faults: tuple[str, ...]
    """What modules do that they must not, and what of them is broken, for people to read."""

    @property
    def located(self) -> bool:
        """Whether hand and fingertips were measured recently enough to render to them."""
        return self.time_s - min(self.pose_s, self.heights_s) <= GAP_S

    def pack(self) -> bytes:
        """Bytes for the recording; nothing is rounded, and the touch packet is named by its sequence number."""
        packed: bytes = _pack(
            [
                self.time_s,
                self.session,
                self.fault_cleared,
                self.engaged,
                self.gap_ns,
                None if self.touch is None else self.touch.sequence,
                self.x_m,
                self.y_m,
                self.z_m,
                self.pose_s,
                self.heights_s,
                self.plate_c,
                self.plate_age_s,
                self.device_faults,
            ]
        )
        return packed

    @classmethod
    def unpack(cls, packed: bytes, touch_of: Callable[[int], Touch | None]) -> "RenderingInput":
        """Read what `pack` wrote.

        Args:
            packed: bytes of the recording.
            touch_of: the touch packet of a sequence number; None when it is lost, and nothing is touched then.

        Raises:
            ValueError: it is something else.
        """
        try:
            fields = read_row(packed, _FIELDS)
        except ValueError as error:
            raise ValueError(f"not a record of rendering input: {error}") from None
        time_s, session, cleared, engaged, gap_ns, sequence, x_m, y_m, z_m, pose_s, heights_s, *plates, faults = fields
        plate_c, plate_age_s = plates
        return cls(
            time_s,
            session,
            cleared,
            engaged,
            gap_ns,
            None if sequence is None else touch_of(sequence),
            x_m,
            y_m,
            tuple(z_m),
            pose_s,
            heights_s,
            tuple(plate_c),
            tuple(plate_age_s),
            tuple(faults),
        )
