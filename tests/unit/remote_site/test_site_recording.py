"""Recordings of the remote site: its readings, and a finger's identification."""

import msgpack
import pytest

from common.fingers import FINGERS
from common.wire.messages import STIFFNESS_KNOWN_LN_SD
from remote_site.devices.sensor_frame import SensorFrame
from remote_site.safety.setpoints import GatedCommand
from remote_site.site_recording import SCHEMAS, SiteRecording
from tests.unit.remote_site.shipped_tables import perception

FIVE = (0.0,) * len(FINGERS)
SENSED = SensorFrame(1.0, 0.0, 0.0, FIVE, FIVE, (None,) * len(FINGERS), (None,) * len(FINGERS), None)

COMMAND = GatedCommand(True, False, 0.0, 0.0, list(FIVE), list(FIVE), [0] * len(FINGERS), None)


class Kept:
    """A recorder that keeps what is written."""

    def __init__(self) -> None:
        self.written: dict[str, bytes] = {}

    def write(self, topic: str, time_ns: int, data: bytes) -> None:
        self.written[topic] = data


@pytest.mark.parametrize(("ln_sd", "recorded"), [(0.02, 850.0), (STIFFNESS_KNOWN_LN_SD, None), (10.0, None)])
def test_a_stiffness_that_is_not_yet_known_is_recorded_as_none(ln_sd: float, recorded: float | None) -> None:
    identified = perception(["index"])
    identified.step(SENSED)
    identified.work()
    surface = identified.touches[1].surface
    surface.stiffness_n_m, surface.stiffness_ln_sd = 850.0, ln_sd
    kept = Kept()
    recording = SiteRecording(kept)  # type: ignore[arg-type]
    recording.tick(1, None, SENSED, None, (), COMMAND, identified.touches)
    assert msgpack.unpackb(kept.written["remote/thermal"])[-1] == recorded
    assert "stiffness_n_m or null" in str(SCHEMAS["remote/thermal"]["description"])


def test_a_recording_without_the_hands_time_is_refused_with_the_reason() -> None:
    packed = msgpack.packb([0.0, 0.0, 0.0, [0.0] * 5, [0.0] * 5, [None] * 5, [None] * 5])
    with pytest.raises(ValueError, match="earlier version"):
        SensorFrame.unpack(packed)
