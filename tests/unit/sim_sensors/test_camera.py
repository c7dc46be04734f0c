"""The simulated camera: its picture, its stamp, and its bytes as a client reads them."""

import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, closing

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.config.simulation_models import SimCameraConfig
from common.fingers import FINGERS
from common.scenes.scene import load_scene
from sim_sensors.physics.camera_stamp import Luma, draw_stamp, read_stamp
from sim_sensors.physics.camera_view import CameraView
from sim_sensors.ports.camera_server import MOST_CLIENTS, CameraServer
from sim_sensors.ports.select_loop import SelectLoop
from tests.waiting import wait_until

WIDTH, HEIGHT = 160, 96
SIZE = WIDTH * HEIGHT * 3 // 2
NOTHING_N = np.zeros(5)


@given(st.floats(0.0, 1e7), st.lists(st.booleans(), min_size=5, max_size=5), st.floats(-7000.0, 7000.0))
def test_a_stamp_is_read_as_it_was_drawn(time_s: float, contacts: list[bool], off_s: float) -> None:
    luma = np.full((HEIGHT, WIDTH), 90, dtype=np.uint8)
    draw_stamp(luma, time_s, np.array(contacts))
    found = read_stamp(luma, time_s + off_s)
    assert found is not None
    assert found[0] == pytest.approx(time_s, abs=0.0006)
    assert found[1].tolist() == contacts


def test_a_damaged_stamp_is_not_read() -> None:
    luma = np.full((HEIGHT, WIDTH), 90, dtype=np.uint8)
    draw_stamp(luma, 12.345, np.ones(5, dtype=bool))
    luma[-4:, :4] = 255 - luma[-4:, :4]
    assert read_stamp(luma, 12.0) is None


def luma_of(picture: bytes) -> Luma:
    return np.frombuffer(picture, np.uint8, WIDTH * HEIGHT).reshape(HEIGHT, WIDTH)


def test_the_picture_shows_where_the_fingers_are_and_which_ones_press() -> None:
    view = CameraView(load_scene("materials"), FINGERS, WIDTH, HEIGHT)
    force_n = np.array([0.0, 2.0, 0.0, 0.0, 0.0])
    picture = view.draw(3.0, 0.05, 0.0, force_n)
    assert len(picture) == SIZE
    without = view.draw(3.0, 0.25, 0.0, force_n)
    column, row = view.place(0.05, -0.02)
    changed = np.abs(luma_of(picture).astype(int) - luma_of(without)) > 20
    assert changed[round(row), round(column)]
    stamp = read_stamp(luma_of(picture), 3.0)
    assert stamp is not None
    assert stamp[1].tolist() == [False, True, False, False, False]


def test_an_object_is_drawn_where_the_fingers_feel_it() -> None:
    """The phantom reaches from -65 to 65 mm along y; the picture beside it shows the bench."""
    view = CameraView(load_scene("phantom_nodules"), FINGERS, WIDTH, HEIGHT)
    luma = luma_of(view.draw(0.0, 0.5, 0.0, NOTHING_N))
    pixels = [view.place(0.0, y_m) for y_m in (-0.075, -0.060, 0.0, 0.060, 0.075)]
    bench, *phantom, beyond = (luma[round(row), round(column)] for column, row in pixels)
    assert bench == beyond
    assert set(phantom) == {phantom[0]} != {bench}


def test_the_face_changes_with_force_only() -> None:
    view = CameraView(load_scene("materials"), FINGERS, WIDTH, HEIGHT)
    calm, pressed = (luma_of(view.draw(1.0, 0.0, 0.0, np.full(5, force_n))) for force_n in (0.0, 5.0))
    face = (slice(4, 28), slice(WIDTH - 28, WIDTH - 4))
    assert (calm[face] != pressed[face]).sum() > 20


@pytest.fixture
def served() -> Iterator[tuple[CameraServer, SelectLoop, list[float]]]:
    loop, drawn = SelectLoop(), list[float]()

    def draw(now_s: float) -> bytes:
        drawn.append(now_s)
        return bytes(SIZE)

    config = SimCameraConfig(port="tcp:127.0.0.1:0", width=WIDTH, height=HEIGHT, rate_hz=10)
    with closing(CameraServer(config, loop, draw, 0.0)) as server:
        yield server, loop, drawn


def connect(server: CameraServer, loop: SelectLoop) -> socket.socket:
    client = socket.create_connection(("127.0.0.1", int(server.address.rpartition(":")[2])))
    loop.serve(0.0)
    return client


def test_nothing_is_drawn_without_a_client(served: tuple[CameraServer, SelectLoop, list[float]]) -> None:
    server, _, drawn = served
    for number in range(100):
        server.pump(0.01 * number)
    assert drawn == []


def test_a_client_gets_a_header_and_each_picture_at_its_time(
    served: tuple[CameraServer, SelectLoop, list[float]],
) -> None:
    server, loop, drawn = served
    with connect(server, loop) as client, client.makefile("rb") as stream:
        client.settimeout(10.0)
        for number in range(101):
            server.pump(0.005 * number)
        assert drawn == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5], abs=0.011)
        assert stream.readline() == b"YUV4MPEG2 W160 H96 F10:1 Ip A1:1 C420jpeg\n"
        for _ in drawn:
            assert stream.readline() == b"FRAME\n"
            assert stream.read(SIZE) == bytes(SIZE)


def test_clients_are_limited(served: tuple[CameraServer, SelectLoop, list[float]]) -> None:
    server, loop, _ = served
    with ExitStack() as opened:
        clients = [opened.enter_context(connect(server, loop)) for _ in range(MOST_CLIENTS + 1)]
        clients[-1].settimeout(10.0)
        assert clients[-1].recv(1) == b""
        server.pump(1.0)
        assert clients[0].recv(10) == b"YUV4MPEG2 "


def test_a_slow_client_misses_pictures_and_a_gone_one_ends(
    served: tuple[CameraServer, SelectLoop, list[float]],
) -> None:
    server, loop, drawn = served
    client = connect(server, loop)
    for number in range(3000):
        server.pump(0.1 * number)
    assert server.omitted > 1000
    client.close()
    for number in range(3000, 3010):
        server.pump(0.1 * number)
    count = len(drawn)
    server.pump(310.0)
    assert len(drawn) == count


def test_a_frozen_camera_sends_nothing(served: tuple[CameraServer, SelectLoop, list[float]]) -> None:
    server, loop, drawn = served
    with connect(server, loop):
        server.frozen = True
        server.pump(1.0)
        assert drawn == []
        server.frozen = False
        server.pump(2.0)
        assert drawn == [2.0]


def test_a_client_that_leaves_a_frozen_camera_is_hung_up_on(
    served: tuple[CameraServer, SelectLoop, list[float]],
) -> None:
    server, loop, _ = served
    server.frozen = True
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(3):
        with connect(server, loop):
            server.pump(1.0)
        wait_until(lambda: server.pump(1.0) or len(os.listdir("/proc/self/fd")) == before)  # type: ignore[func-returns-value]


@pytest.mark.parametrize("port", ["pty", "tcp:127.0.0.1", "tcp:127.0.0.1:x", "tcp:127.0.0.1:²"])
def test_a_malformed_address_is_named(port: str) -> None:
    with pytest.raises(ValueError, match=r"camera: .* is not tcp:HOST:PORT"):
        CameraServer(SimCameraConfig(port=port), SelectLoop(), lambda now_s: b"", 0.0)
