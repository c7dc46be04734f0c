"""The console's end of the stream `camera` over real Curve: loss, restart, refused key, damage, size, silence."""

import errno
from collections.abc import Iterator
from unittest.mock import Mock

import pytest
import zmq

from common.limits import FROZEN_S
from common.link.keys import TrustedKeys, load_keys
from common.wire.camera_messages import MAX_PICTURE
from operator_site.console.camera.camera import Camera
from operator_site.console.camera.camera_now import Seen
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.stream_socket import StreamSocket
from tests.conftest import Keys
from tests.unit.operator_site.console.camera.fake_camera import FakeCamera, until

pytestmark = pytest.mark.timeout(60)


class Both:
    """A camera's process and its reader on one machine."""

    def __init__(self, base_port: int, keys: Keys, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("operator_site.console.stream_socket.RECONNECT_S", 0.3)
        self._port, self._keys = base_port, keys
        self.process: FakeCamera | None = None
        remote = load_keys(keys.remote).public
        self.line = StreamSocket("camera", "127.0.0.1", base_port, load_keys(keys.operator), remote, MAX_PICTURE)
        self.reader = Camera(self.line, required=True)
        self.taken: list[Picture] = []

    def start(self) -> FakeCamera:
        self.process = FakeCamera(self._port, self._keys)
        return self.process

    def end(self) -> None:
        if self.process is not None:
            self.process.close()
        self.process = None

    def step(self) -> None:
        self.taken += self.reader.step(7, 0.012, wants_key=False)
        if self.process is not None:
            self.process.hear()

    def asked(self) -> bool:
        """Whether the process has read a packet."""
        self.step()
        return self.process is not None and bool(self.process.asks)

    def took(self, sequence: int) -> bool:
        """Whether this picture has come."""
        self.step()
        return bool(self.taken) and self.taken[-1].sequence == sequence

    def sees(self, seen: Seen) -> bool:
        self.step()
        return self.reader.now.seen is seen

    def damaged(self) -> int:
        self.step()
        damaged = self.reader.figures()["camera_damaged"]
        assert isinstance(damaged, int)
        return damaged

    def close(self) -> None:
        self.end()
        self.reader.close()


@pytest.fixture
def both(base_port: int, keys: Keys, monkeypatch: pytest.MonkeyPatch) -> Iterator[Both]:
    made = Both(base_port, keys, monkeypatch)
    yield made
    made.close()


@pytest.mark.long
def test_an_absent_camera_is_named_and_one_that_comes_later_is_seen(both: Both) -> None:
    until(lambda: both.sees(Seen.SILENT))
    assert both.reader.now.holds
    process = both.start()
    until(both.asked)
    until(lambda: both.step() or any(ask.wants_key for ask in process.asks))
    assert (process.asks[0].session, process.asks[0].touch_age_us) == (7, 12_000)
    process.send(1)
    until(lambda: both.took(1))
    assert both.reader.now.seen is Seen.LIVE
    assert 0.0 <= both.taken[0].uncertainty_s < 0.5
    until(lambda: both.step() or process.asks[-1].sequence == 1)


@pytest.mark.long
def test_a_lost_camera_is_frozen_then_silent_and_its_next_start_is_followed(both: Both) -> None:
    process = both.start()
    until(both.asked)
    process.send(1)
    until(lambda: both.took(1))
    both.end()
    until(lambda: both.sees(Seen.FROZEN))
    assert both.reader.now.age_s < 0.6
    until(lambda: both.sees(Seen.SILENT))
    process = both.start()
    until(both.asked)
    process.send(1)
    until(lambda: both.sees(Seen.LIVE))


@pytest.mark.long
def test_a_camera_is_seen_again_after_a_time_without_a_free_descriptor(
    both: Both, monkeypatch: pytest.MonkeyPatch
) -> None:
    until(lambda: both.sees(Seen.SILENT))
    with monkeypatch.context() as full:
        full.setattr(both.line._context, "socket", Mock(side_effect=zmq.ZMQError(errno.EMFILE)))
        both.line.reconnect()
        both.step()
    process = both.start()
    until(both.asked)
    process.send(1)
    until(lambda: both.sees(Seen.LIVE))


@pytest.mark.long
def test_a_refused_key_is_named_and_taken_once_it_is_trusted(both: Both, keys: Keys) -> None:
    public = load_keys(keys.operator).public
    TrustedKeys(keys.remote).revoke("operator")
    both.start()
    until(lambda: both.sees(Seen.REFUSED))
    TrustedKeys(keys.remote).trust("operator", public)
    until(both.asked)
    assert both.reader.now.seen is not Seen.REFUSED


def test_a_damaged_header_is_dropped_and_the_next_picture_is_shown(both: Both) -> None:
    process = both.start()
    until(both.asked)
    process.send_raw(b"damaged", b"picture")
    process.send_raw(process.header(1).encode())
    until(lambda: both.damaged() == 2)
    process.send(2)
    until(lambda: both.took(2))


@pytest.mark.long
def test_an_oversized_picture_ends_the_connection_only(both: Both) -> None:
    process = both.start()
    until(both.asked)
    process.send(1, bytes(MAX_PICTURE + 1000))
    asked = len(process.asks)
    until(lambda: both.step() or len(process.asks) > asked)
    process.send(2, bytes(MAX_PICTURE))
    until(lambda: both.took(2))
    assert [picture.sequence for picture in both.taken] == [2]


@pytest.mark.long
def test_a_camera_that_answers_without_pictures_is_frozen(both: Both) -> None:
    process = both.start()
    until(both.asked)
    process.send(1)
    until(lambda: both.took(1))

    def repeated() -> bool:
        process.send(1, b"", is_key=False)
        return both.sees(Seen.FROZEN)

    until(repeated)
    assert both.reader.now.age_s > FROZEN_S
