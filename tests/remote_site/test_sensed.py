"""What the remote site sensed in a tick, as it is recorded."""

import msgpack
import pytest

from remote_site.sensed import Sensed


def test_a_recording_of_before_the_hands_time_was_in_it_is_refused_in_words() -> None:
    packed = msgpack.packb([0.0, 0.0, 0.0, [0.0] * 5, [0.0] * 5, [None] * 5, [None] * 5])
    with pytest.raises(ValueError, match="earlier version"):
        Sensed.unpack(packed)
