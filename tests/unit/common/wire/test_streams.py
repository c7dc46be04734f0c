import pytest

from common.limits import GAP_S
from common.wire.streams import STREAMS, Direction, Stream


def test_each_stream_has_its_own_name_and_port() -> None:
    assert [stream.port for stream in STREAMS.values()] == list(range(7))
    assert all(name == stream.name for name, stream in STREAMS.items())
    assert list(STREAMS) == ["motion", "touch", "heartbeat", "control", "observed", "camera", "voice"]


def test_a_gap_covers_three_periods_of_what_is_latest_only() -> None:
    for stream in STREAMS.values():
        if stream.latest_only:
            assert 3.0 / stream.rate_hz <= GAP_S
            assert stream.direction is not Direction.BOTH
    with pytest.raises(ValueError, match=r"slow: a gap of 0\.1 s must cover three periods"):
        Stream("slow", Direction.TO_REMOTE, 20.0, latest_only=True, port=9, recorded=True)
    with pytest.raises(ValueError, match="three periods"):
        Stream("none", Direction.TO_REMOTE, float("nan"), latest_only=True, port=9, recorded=True)
