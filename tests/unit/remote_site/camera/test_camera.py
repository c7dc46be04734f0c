"""The camera's process against a simulated network camera and a reader with real keys."""

import time
import wave
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, field
from pathlib import Path

import av
import numpy as np
import pytest
import zmq
from numpy.typing import NDArray

from common.config.link_models import RemoteLinkConfig
from common.config.simulation_models import SimCameraConfig
from common.config.stream_models import CameraConfig
from common.fingers import FINGERS
from common.link.clock_offset import ClockOffset
from common.link.curve import LinkProblem, prepare_socket, use_curve
from common.link.keys import TrustedKeys, load_keys
from common.scenes.scene import load_scene
from common.wire.camera_messages import MAX_PICTURE, CameraAsk, CameraState, PictureHeader, read_picture
from common.wire.streams import STREAMS
from remote_site.camera.camera import Camera
from remote_site.camera.video_source import VideoSource
from remote_site.stream_server import StreamServer
from sim_sensors.physics.camera_stamp import read_stamp
from sim_sensors.physics.camera_view import CameraView
from sim_sensors.ports.camera_server import CameraServer
from sim_sensors.ports.select_loop import SelectLoop
from tests.conftest import Keys
from tests.descriptors import many_open_files
from tests.waiting import wait_until

WIDTH, HEIGHT, RATE_HZ = 320, 192, 30
PRESS_N = np.array([0.0, 1.0, 0.0, 0.0, 2.0])
ALIGNED_S = 0.005
"""Largest error of a picture's time of capture, s: the median, because other tests take the processor from it."""


@dataclass
class Reader:
    """A reader of the stream that decodes what it gets."""

    socket: "zmq.Socket[bytes]"
    pictures: list[tuple[PictureHeader, NDArray[np.uint8]]] = field(default_factory=list)
    headers: list[PictureHeader] = field(default_factory=list)
    clock: ClockOffset = field(default_factory=ClockOffset)

    def __post_init__(self) -> None:
        self._decoder = av.CodecContext.create("vp8", "r")

    def ask(self, wants_key: bool = False, touch_age_us: int = 0) -> None:
        sequence = self.headers[-1].sequence if self.headers else 0
        self.send(CameraAsk(0, sequence, time.monotonic_ns(), touch_age_us, 0, wants_key).encode())

    def send(self, packet: bytes) -> None:
        with suppress(zmq.Again):  # it is cut off
            self.socket.send(packet, zmq.DONTWAIT)

    def receive(self) -> None:
        while self.socket.poll(0):
            now_ns = time.monotonic_ns()
            header, picture = read_picture(self.socket.recv_multipart())
            self.headers.append(header)
            if header.asked_ns:
                self.clock.add(header.asked_ns, header.heard_ns, header.sent_ns, now_ns)
            if picture:
                for frame in self._decoder.decode(av.Packet(picture)):
                    self.pictures.append((header, frame.to_ndarray()[: header.height]))
                self.ask()


class Stage:
    """A simulated camera, the camera's process in this thread, and readers."""

    def __init__(self, keys: Keys, base_port: int, opened: ExitStack) -> None:
        self.keys, self.base_port = keys, base_port
        self._opened, self._sockets = opened, SelectLoop()
        view = CameraView(load_scene("materials"), FINGERS, WIDTH, HEIGHT)
        config = SimCameraConfig(port="tcp:127.0.0.1:0", width=WIDTH, height=HEIGHT, rate_hz=RATE_HZ)
        self.server = CameraServer(
            config, self._sockets, lambda now_s: view.draw(now_s, 0.05, 0.0, PRESS_N), self._sockets.now()
        )
        opened.callback(self._close_server)
        link = RemoteLinkConfig(base_port=base_port, keys=keys.remote)
        self.config = CameraConfig(
            link=link, source=self.server.address, width=WIDTH, height=HEIGHT, rate_hz=RATE_HZ, bit_s=200_000
        )
        self.link = opened.enter_context(closing(StreamServer(link, "camera")))
        source = VideoSource(self.config.source, (WIDTH, HEIGHT), RATE_HZ, 0.0)
        opened.callback(source.close)
        self.camera = Camera(self.config, self.link, source)
        self._context = zmq.Context()
        opened.callback(self._context.destroy, 0)
        self.readers: list[Reader] = []

    def reader(self, own: str = "operator") -> Reader:
        socket = self._context.socket(zmq.DEALER)
        prepare_socket(socket, MAX_PICTURE)
        use_curve(socket, load_keys(getattr(self.keys, own)), load_keys(self.keys.remote).public)
        socket.connect(f"tcp://127.0.0.1:{self.base_port + STREAMS['camera'].port}")
        self.readers.append(reader := Reader(socket))
        return reader

    def until(self, reached: Callable[[], object]) -> None:
        """Run everything until something is reached."""

        def turn() -> object:
            self._sockets.serve(0.002)
            self.server.pump(self._sockets.now())
            self.camera.step(time.monotonic_ns())
            for reader in self.readers:
                reader.receive()
            return reached()

        wait_until(turn, self.camera.figures, every_s=0.0)

    def _close_server(self) -> None:
        self.server.close()


@pytest.fixture
def stage(keys: Keys, base_port: int) -> Iterator[Stage]:
    with ExitStack() as opened:
        yield Stage(keys, base_port, opened)


@pytest.mark.long
def test_pictures_arrive_with_their_time_of_capture_and_what_touches(stage: Stage) -> None:
    reader = stage.reader()
    reader.ask()
    stage.until(lambda: len(reader.pictures) >= 20)
    header, first = reader.pictures[0]
    assert (header.is_key, header.state, header.rung) == (True, CameraState.SHOWING, 0)
    assert first.shape == (HEIGHT, WIDTH)
    errors_s = []
    for header, luma in reader.pictures:
        stamp = read_stamp(luma, time.monotonic())
        assert stamp is not None
        assert stamp[1].tolist() == (PRESS_N > 0.0).tolist()
        errors_s.append((header.time_ns - reader.clock.offset_ns) * 1e-9 - stamp[0])
    assert np.median(np.abs(errors_s)) < ALIGNED_S, errors_s
    sequences = [header.sequence for header, _ in reader.pictures]
    assert sequences == list(range(sequences[0], sequences[0] + len(sequences)))


@pytest.mark.long
def test_a_second_reader_begins_with_a_key_picture(stage: Stage, keys: Keys) -> None:
    first = stage.reader()
    first.ask()
    stage.until(lambda: len(first.pictures) >= 5)
    TrustedKeys(keys.remote).trust("second", load_keys(keys.stranger).public)
    second = stage.reader("stranger")
    second.ask()
    stage.until(lambda: second.pictures)
    assert second.pictures[0][0].is_key


@pytest.mark.long
def test_a_key_that_is_not_trusted_gets_nothing_and_a_revoked_one_no_more(stage: Stage, keys: Keys) -> None:
    stranger, reader = stage.reader("stranger"), stage.reader()
    stranger.ask()
    reader.ask()
    stage.until(lambda: len(reader.pictures) >= 5)
    assert stranger.headers == []
    TrustedKeys(keys.remote).revoke("operator")
    stage.link.recheck_keys()
    stage.until(lambda: stage.camera.figures()["readers"] == 0)
    count = len(reader.headers)
    reader.ask()
    stage.until(lambda: stage.link.socket is not None)
    assert len(reader.headers) == count


@pytest.mark.long
def test_packets_that_are_none_are_counted_and_end_nothing(stage: Stage) -> None:
    reader = stage.reader()
    reader.send(b"")
    reader.send(b"\xff" * 100)
    reader.ask()
    stage.until(lambda: reader.pictures)
    assert stage.camera.counts["bad packets"] == 2


@pytest.mark.long
def test_a_camera_that_freezes_keeps_answering_with_an_old_time(stage: Stage) -> None:
    reader = stage.reader()
    reader.ask()
    stage.until(lambda: len(reader.pictures) >= 3)
    stage.server.frozen = True
    frozen_ns = time.monotonic_ns()

    def old() -> bool:
        reader.ask()
        return reader.headers[-1].sent_ns - reader.headers[-1].time_ns > 500_000_000

    stage.until(old)
    assert reader.headers[-1].time_ns <= frozen_ns + 100_000_000


@pytest.mark.long
def test_a_camera_that_is_gone_is_named_and_returns(stage: Stage) -> None:
    reader = stage.reader()
    reader.ask()
    stage.until(lambda: len(reader.pictures) >= 3)
    address = stage.server.address.rpartition(":")[2]
    stage.server.close()

    def state(wanted: CameraState) -> bool:
        reader.ask()
        return reader.headers[-1].state is wanted

    stage.until(lambda: state(CameraState.NO_CAMERA))
    assert stage.camera.figures()["missing"]
    stage.server = CameraServer(
        SimCameraConfig(port=f"tcp:127.0.0.1:{address}", width=WIDTH, height=HEIGHT, rate_hz=RATE_HZ),
        stage._sockets,
        lambda now_s: bytes(WIDTH * HEIGHT * 3 // 2),
        stage._sockets.now(),
    )
    stage.until(lambda: state(CameraState.SHOWING))


def test_the_server_waits_while_many_files_are_open(keys: Keys, base_port: int) -> None:
    link = RemoteLinkConfig(base_port=base_port, keys=keys.remote)
    with many_open_files(), closing(StreamServer(link, "camera")) as server:
        server.wait(0.01)


def test_a_long_message_in_parts_delays_no_other_reader(keys: Keys, base_port: int) -> None:
    def reader(folder: Path, context: "zmq.Context[zmq.Socket[bytes]]") -> "zmq.Socket[bytes]":
        socket = context.socket(zmq.DEALER)
        prepare_socket(socket)
        use_curve(socket, load_keys(folder), load_keys(keys.remote).public)
        socket.connect(f"tcp://127.0.0.1:{base_port + STREAMS['camera'].port}")
        return socket

    TrustedKeys(keys.remote).trust("colleague", load_keys(keys.stranger).public)
    link = RemoteLinkConfig(base_port=base_port, keys=keys.remote)
    with (
        closing(StreamServer(link, "camera")) as server,
        zmq.Context() as context,
        reader(keys.operator, context) as own,
        reader(keys.stranger, context) as other,
    ):
        other.send_multipart([b"part"] * 20_000)
        first, received = server.socket, []

        def bound_again() -> bool:
            received.extend(server.receive())
            return server.socket is not first

        wait_until(bound_again)

        def asked() -> bool:
            own.send(b"?")
            received.extend(server.receive())
            return any(sender.key == load_keys(keys.operator).public for sender, _ in received)

        wait_until(asked)
        assert {packet for _, packet in received} == {b"?"}


@pytest.mark.long
def test_the_picture_shrinks_while_touch_grows_older(stage: Stage) -> None:
    reader = stage.reader()
    reader.ask(touch_age_us=20_000)
    stage.until(lambda: reader.pictures)

    def smaller() -> bool:
        reader.ask(touch_age_us=60_000)
        return bool(reader.headers[-1].state is CameraState.GIVES_WAY and reader.headers[-1].width < WIDTH)

    stage.until(smaller)


@pytest.mark.long
def test_after_a_picture_that_is_too_large_a_key_picture_follows(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    reader = stage.reader()
    reader.ask()
    stage.until(lambda: len(reader.pictures) >= 3)
    with monkeypatch.context() as tight:
        tight.setattr("remote_site.camera.camera.MAX_PICTURE", 0)
        before = stage.camera.figures()["sequence"]
        stage.until(lambda: stage.camera.figures()["sequence"] != before)
    count = len(reader.pictures)
    stage.until(lambda: len(reader.pictures) > count)
    assert reader.pictures[count][0].is_key


def test_a_taken_port_is_a_link_problem(stage: Stage, keys: Keys, base_port: int) -> None:
    with pytest.raises(LinkProblem, match=r"\(camera\): .*in use"):
        StreamServer(RemoteLinkConfig(base_port=base_port, keys=keys.remote), "camera")


def test_a_source_of_sound_alone_is_named_as_one_without_pictures(tmp_path: Path) -> None:
    with wave.open(str(tmp_path / "sound.wav"), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(8000)
        file.writeframes(bytes(16000))
    with closing(VideoSource(str(tmp_path / "sound.wav"), (WIDTH, HEIGHT), RATE_HZ, 0.0)) as source:
        wait_until(lambda: source.problem.endswith("sound.wav: has no pictures"), lambda: source.problem)
