"""Record the true state of fingers and objects beside a session, as the reference for all measurements."""

from collections.abc import Mapping
from pathlib import Path

import msgpack

from common.recording.recorder import Recorder, recording_figures

_NUMBER = {"type": "number"}
_WHOLE = {"type": "integer"}
_TEXT = {"type": "string"}
_FIVE = {"type": "array", "items": _NUMBER, "minItems": 5, "maxItems": 5}
_FIVE_WHOLE = {"type": "array", "items": _WHOLE, "minItems": 5, "maxItems": 5}


def _schema(**fields: Mapping[str, object]) -> dict[str, object]:
    return {"type": "object", "properties": fields, "required": list(fields)}


OPERATOR_STREAMS = {
    "truth_fingertips": _schema(
        motor_rpm=_FIVE,
        motor_mv=_FIVE_WHOLE,
        plate_c=_FIVE,
        hot_side_c=_FIVE,
        peltier=_FIVE,
        surface_c=_FIVE,
        felt_c=_FIVE,
        force_n=_FIVE,
        z_m=_FIVE,
        x_m=_NUMBER,
        y_m=_NUMBER,
        script_mode=_WHOLE,
        act=_TEXT,
        object=_TEXT,
    ),
    "truth_motor": _schema(finger=_WHOLE, motor_mv=_WHOLE),
}
"""Streams of the operator's fingers: state at 100 Hz, and each time at which a module's motor is switched on or off."""

REMOTE_STREAMS = {
    "truth_contact": _schema(
        mode=_FIVE_WHOLE,
        object=_FIVE_WHOLE,
        force_n=_FIVE,
        plate_c=_FIVE,
        heater=_FIVE,
        z_m=_FIVE,
        x_m=_NUMBER,
        y_m=_NUMBER,
    ),
    "truth_event": _schema(
        finger=_WHOLE,
        kind=_TEXT,
        object=_TEXT,
        object_c=_NUMBER,
        material=_TEXT,
        approach_m_s=_NUMBER,
        mode=_WHOLE,
    ),
}
"""Streams of the remote fingers: state at 100 Hz, and each contact, release and crossed groove."""

LOG_EVERY = 5
"""Steps of 2 ms from one 100 Hz entry to the next."""


class TruthLog:
    """Writer of the truth to an MCAP file; without a file, it writes nothing."""

    def __init__(
        self, path: Path | None, streams: Mapping[str, Mapping[str, object]], metadata: Mapping[str, str]
    ) -> None:
        """Open the file; raises ValueError where it cannot be created."""
        try:
            self._recorder = Recorder(path, streams, metadata) if path is not None else None
        except OSError as error:
            raise ValueError(f"record: cannot write {path}: {error.strerror}") from None

    @property
    def open(self) -> bool:
        """Whether there is a file; without one, the caller need not build entries."""
        return self._recorder is not None

    def write(self, stream: str, time_s: float, entry: Mapping[str, object]) -> None:
        """Write one entry with its time on the monotonic clock, s."""
        if self._recorder is not None:
            self._recorder.write(stream, round(time_s * 1e9), msgpack.packb(entry))

    def figures(self) -> dict[str, object]:
        """Return what a status file says of the recording."""
        return recording_figures(self._recorder)

    def close(self) -> None:
        """Finish the file."""
        if self._recorder is not None:
            self._recorder.close()
