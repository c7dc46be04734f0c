"""The age of what a camera gives, and cameras that hang or that the library cannot read."""

import io
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import closing, suppress
from types import SimpleNamespace

import av
import numpy as np
import pytest

from remote_site.camera import video_source
from remote_site.camera.video_source import Captured, VideoSource
from tests.waiting import wait_until

RATE_HZ = 25
STALLED_S = 1.2


def _pieces(seconds: float) -> list[bytes]:
    """Return a stream with time stamps, in one piece for each picture."""
    file = io.BytesIO()
    pieces = []
    with av.open(file, "w", format="mpegts") as container:
        stream = container.add_stream("mpeg2video", rate=RATE_HZ)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for number in range(round(seconds * RATE_HZ)):
            shown = np.full((48, 64, 3), number % 256, np.uint8)
            for packet in stream.encode(av.VideoFrame.from_ndarray(shown, format="rgb24")):
                container.mux(packet)
            pieces.append(file.getvalue())
            file.seek(0)
            file.truncate()
    return pieces


@pytest.fixture
def stalling() -> Iterator[str]:
    """Address of a camera behind a network that stalls once, and loses nothing."""
    pieces = _pieces(4.0)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            with suppress(OSError), server.accept()[0] as client:
                client.recv(4096)
                client.sendall(b"HTTP/1.0 200 OK\r\nContent-Type: video/mp2t\r\n\r\n")
                begun_s = time.monotonic()
                for number, piece in enumerate(pieces):
                    late_s = STALLED_S if number > 1.5 * RATE_HZ else 0.0
                    time.sleep(max(0.0, begun_s + number / RATE_HZ + late_s - time.monotonic()))
                    client.sendall(piece)

        thread = threading.Thread(target=serve)
        thread.start()
        yield f"http://127.0.0.1:{server.getsockname()[1]}/"
        thread.join()


@pytest.mark.long
def test_pictures_that_waited_on_their_way_are_as_old_as_they_are(stalling: str) -> None:
    ages_s = []
    with closing(VideoSource(stalling, (64, 48), RATE_HZ, 0.0)) as source:

        def late() -> bool:
            if (captured := source.take()) is not None:
                ages_s.append((time.monotonic_ns() - captured.time_ns) * 1e-9)
            return bool(ages_s) and ages_s[-1] > 0.8 * STALLED_S

        wait_until(late, lambda: ages_s)
    assert min(ages_s) < 0.5 * STALLED_S


@pytest.mark.long
def test_a_camera_whose_pictures_stay_late_is_opened_again(stalling: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video_source, "_LATE_S", 0.5 * STALLED_S)
    with closing(VideoSource(stalling, (64, 48), RATE_HZ, 0.0)) as source:
        wait_until(lambda: source.problem.endswith(" s late"), lambda: source.problem)


class Packet(bytes):
    """A packet with one picture."""

    def decode(self) -> list[av.VideoFrame]:
        return [av.VideoFrame(64, 48)]


def test_a_camera_that_repeats_one_picture_has_no_new_one(monkeypatch: pytest.MonkeyPatch) -> None:
    shown, ends = [b"1"], threading.Event()

    class Repeating:
        streams, format = SimpleNamespace(video=[1]), SimpleNamespace(flags=0)

        def __enter__(self) -> "Repeating":
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def demux(self, video: int) -> Iterator[Packet]:
            while not ends.wait(0.005):
                yield Packet(shown[0])

    monkeypatch.setattr(video_source, "_BEHIND_S", 0.0)
    monkeypatch.setattr(video_source, "_REPEATS_S", 0.2)
    monkeypatch.setattr(video_source.av, "open", lambda *_, **__: Repeating())
    with closing(VideoSource("/dev/video0", (64, 48), RATE_HZ, 0.0)) as source:
        wait_until(source.take)
        assert source.repeats == ""
        wait_until(lambda: source.repeats == "/dev/video0: repeats one picture", patience_s=2.0)
        source.take()
        time.sleep(0.05)
        assert (source.take(), source.problem) == (None, ""), "the console calls the last one frozen"
        shown[0] = b"2"
        wait_until(source.take)
        assert source.repeats == ""
        ends.set()


@pytest.mark.parametrize("error", [TypeError("surprise"), MemoryError()])
def test_a_camera_is_opened_again_after_any_error(error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []

    def failing(*_: object, **__: object) -> object:
        opened.append(1)
        raise error

    monkeypatch.setattr(video_source, "AGAIN_S", 0.01)
    monkeypatch.setattr(video_source.av, "open", failing)
    with closing(VideoSource("/dev/video0", (64, 48), RATE_HZ, 0.0)) as source:
        wait_until(lambda: len(opened) > 1)
        assert source.problem.startswith("/dev/video0: ")


def test_a_camera_whose_driver_hangs_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    more = threading.Event()

    class Hanging:
        streams, format = SimpleNamespace(video=[1]), SimpleNamespace(flags=0)

        def __enter__(self) -> "Hanging":
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def demux(self, video: int) -> Iterator[Packet]:
            yield Packet(b"1")
            more.wait()

    for name in ("_BEHIND_S", "_HANGS_S"):
        monkeypatch.setattr(video_source, name, {"_BEHIND_S": 0.0, "_HANGS_S": 0.1}[name])
    monkeypatch.setattr(video_source.av, "open", lambda *_, **__: Hanging())
    with closing(VideoSource("/dev/video0", (64, 48), RATE_HZ, 0.0)) as source:
        found: list[Captured | None] = []
        wait_until(lambda: found.append(source.take()) or any(found))
        assert source.problem == ""
        wait_until(lambda: source.take() or source.problem, patience_s=2.0)
        assert source.problem == "/dev/video0: sends no picture"
        more.set()
