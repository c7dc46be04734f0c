"""What the remote site sensed in a tick, as it is recorded."""

import msgpack
import pytest

from remote_site.sensed import Sensed


def test_a_recording_of_before_readings_had_numbers_is_refused_in_words() -> None:
    packed = msgpack.packb([0.0, 0.0, 0.0, [0.0] * 5, [0.0] * 5, [None] * 5, [[20.0, 21.0, ""], *[None] * 4]])
    with pytest.raises(ValueError, match="recorded by an earlier version"):
        Sensed.unpack(packed)
