import os
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import pytest
import serial

from common.buses.serial_messages import FrameReader, MessageId, TactTipCommand, TactTipState, encode_frame
from sim_sensors.devices.breakable_parts import Babble
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.serial_server import SerialServer, serve_serial
from sim_sensors.serving import SocketServing, serve_fingers
from tests.unit.sim_sensors.stepped import until

COMMAND = encode_frame(MessageId.TACTTIP_COMMAND, 0, TactTipCommand(1234, -500).encode())


class LineContract:
    """What a served module promises, whatever the line."""

    address: str

    @pytest.fixture
    def module(self, loop: SelectLoop) -> TactTip:
        return TactTip(1, loop.now())

    @pytest.fixture
    def server(self, loop: SelectLoop, module: TactTip) -> Iterator[SerialServer]:
        server = serve_serial(module, loop, self.address, "tacttip index")
        yield server
        server.close()

    def open(self, server: SerialServer, loop: SelectLoop) -> serial.SerialBase:
        port = serial.serial_for_url(server.address, timeout=0)
        port.write(b"\0")
        loop.serve(0.01)
        return port

    def test_every_byte_value_passes_unchanged(self, server: SerialServer, loop: SelectLoop, module: TactTip) -> None:
        with self.open(server, loop) as port:
            port.write(COMMAND)
            until(loop, lambda: module.motor_mv == 1234 and module.drive_permille == -500)
            reader, states = FrameReader(), []
            for counts in (0x1113, 0x0A0D, 0x0304):  # XON, XOFF, line ends, interrupt
                module.measure(counts & 0xFFF, counts & 0xFFF)
                start = loop.now()
                while loop.now() < start + 0.012:
                    loop.serve(0.002)
                    server.pump(loop.now())
                loop.serve(0.002)
                states += [TactTipState.decode(f.payload) for f in reader.feed(port.read(4096))]
            assert {0x113, 0xA0D, 0x304} <= {state.plate_counts for state in states}
            assert reader.damaged == 0

    def test_drivers_come_and_go(self, server: SerialServer, loop: SelectLoop, module: TactTip) -> None:
        for motor_mv in (100, 200, 300):
            with self.open(server, loop) as port:
                # The zero byte ends whatever the driver before left half sent; a pty cannot see it go.
                command = TactTipCommand(motor_mv, 0).encode()
                port.write(b"\0" + encode_frame(MessageId.TACTTIP_COMMAND, 0, command))
                until(loop, lambda wanted=motor_mv: module.motor_mv == wanted)  # type: ignore[misc]
                port.write(COMMAND[:4])  # and dies in the middle of a frame; the next one comes at once

    def test_a_driver_that_never_reads_holds_nothing_up(self, server: SerialServer, loop: SelectLoop) -> None:
        with self.open(server, loop):
            start = time.monotonic()
            for n in range(30_000):
                server.send(b"x" * 100)
                if n % 1000 == 0:
                    loop.serve(0.0)
            assert time.monotonic() - start < 2.0
            assert server.backlog.dropped > 1000

    def heard(
        self, server: SerialServer, loop: SelectLoop, port: serial.SerialBase, seconds: float, frames: int = 0
    ) -> tuple[FrameReader, int]:
        """What a driver has read after turning the module for a while, and until this number of frames has come."""
        reader, end, count = FrameReader(), loop.now() + seconds, 0
        while loop.now() < end or count < frames:
            assert loop.now() < end + 10.0
            loop.serve(0.002)
            server.pump(loop.now())
            count += len(reader.feed(port.read(4096)))
        return reader, count

    def test_a_pulled_cable_ends_the_connection_and_the_same_address_answers_when_it_is_back(
        self, server: SerialServer, loop: SelectLoop, module: TactTip
    ) -> None:
        address = server.address
        for _ in range(2):
            with self.open(server, loop) as port:
                connection = getattr(port, "_socket", None)
                server.unplug()
                server.unplug()  # nothing more to pull

                def ended(port: serial.SerialBase = port) -> bool:
                    server.pump(loop.now())
                    try:
                        port.read(4096)
                        port.write(COMMAND)
                    except serial.SerialException:
                        return True
                    return False

                until(loop, ended)
            if connection is not None:
                connection.close()  # the library forgets to when the far side has gone first
            with pytest.raises(serial.SerialException):
                serial.serial_for_url(address, timeout=0)
            module.motor_mv = 0
            server.plug()
            server.plug()
            assert server.address == address
            with self.open(server, loop) as port:
                port.write(b"\0" + COMMAND)
                until(loop, lambda: module.motor_mv == 1234)

    def test_a_silent_module_neither_says_nor_hears_anything_and_a_deaf_one_only_reports_while_the_line_is_open(
        self, server: SerialServer, loop: SelectLoop, module: TactTip
    ) -> None:
        with self.open(server, loop) as port:
            self.heard(server, loop, port, 0.02)
            server.silent = True
            port.read(4096)
            port.write(COMMAND)
            _, frames = self.heard(server, loop, port, 0.05)
            assert (frames, module.motor_mv) == (0, 0)
            server.silent, server.deaf = False, True
            port.write(COMMAND)
            self.heard(server, loop, port, 0.05, frames=2)
            assert module.motor_mv == 0
            server.deaf = False
            port.write(COMMAND)
            until(loop, lambda: module.motor_mv == 1234)

    def test_a_babbling_module_is_still_understood(
        self, server: SerialServer, loop: SelectLoop, module: TactTip
    ) -> None:
        server.babble = Babble(921_600)
        with self.open(server, loop) as port:
            reader, _ = self.heard(server, loop, port, 0.2, frames=5)
            assert reader.damaged > 10
            port.write(COMMAND)
            until(loop, lambda: module.motor_mv == 1234)


class TestPty(LineContract):
    address = "pty"

    def test_its_name_is_there_exactly_while_it_can_be_opened(self, server: SerialServer) -> None:
        name = Path(server.address)
        assert name.name == "tacttip-index"
        for _ in range(2):
            assert name.exists()
            server.unplug()
            assert not os.path.lexists(name)
            server.plug()
        server.close()
        assert not name.parent.exists()


class TestTcp(LineContract):
    address = "tcp:127.0.0.1:0"

    def connect(self, server: SerialServer) -> socket.socket:
        host, _, port = server.address.removeprefix("socket://").rpartition(":")
        connection = socket.create_connection((host, int(port)))
        connection.setblocking(False)
        return connection

    def read(self, server: SerialServer, loop: SelectLoop, connection: socket.socket, seconds: float) -> bytes | None:
        """What a client is sent in some time; None once the module has hung up on it."""
        data, end = b"", loop.now() + seconds
        while loop.now() < end:
            loop.serve(0.002)
            server.pump(loop.now())
            try:
                piece = connection.recv(65536)
            except BlockingIOError:
                continue
            except ConnectionError:
                return None
            if not piece:
                return None
            data += piece
        return data

    @pytest.mark.parametrize("said", [b"GET / HTTP/1.1\r\n\r\n", b"SSH-2.0-x\r\n", b"\x01\0", COMMAND])
    def test_a_stranger_is_sent_nothing_and_hung_up_on(
        self, server: SerialServer, loop: SelectLoop, module: TactTip, said: bytes
    ) -> None:
        with self.connect(server) as stranger:
            assert self.read(server, loop, stranger, 0.1) == b"", "no report before it has shown what it is"
            stranger.sendall(said)
            assert self.read(server, loop, stranger, 2.0) is None
        assert module.motor_mv == 0

    def test_one_that_says_nothing_is_hung_up_on_after_a_while(self, server: SerialServer, loop: SelectLoop) -> None:
        with self.connect(server) as silent:
            assert self.read(server, loop, silent, 3.0) is None

    def test_ones_that_say_nothing_do_not_pile_up_and_do_not_keep_a_driver_out(
        self, server: SerialServer, loop: SelectLoop, module: TactTip
    ) -> None:
        crowd = []
        for _ in range(50):
            crowd.append(self.connect(server))
            loop.serve(0.0)
        with self.open(server, loop) as port:
            port.write(COMMAND)
            until(loop, lambda: module.motor_mv == 1234)
        for each in crowd:
            each.close()

    @pytest.mark.parametrize("sends", [False, True])
    def test_a_second_client_does_not_take_the_line_from_a_live_one(
        self, server: SerialServer, loop: SelectLoop, module: TactTip, sends: bool
    ) -> None:
        """One that sends commands, and one that only reads, as a texture sensor's driver does."""
        with self.open(server, loop) as old:
            for _ in range(5):
                if sends:
                    old.write(COMMAND)
                with self.connect(server) as second:
                    second.sendall(b"\0" + encode_frame(MessageId.IDENTIFY, 0))
                    assert self.read(server, loop, second, 1.0) is None
            self.heard(server, loop, old, 0.1, frames=5)

    def test_a_new_client_takes_over_from_a_half_dead_one(
        self, server: SerialServer, loop: SelectLoop, module: TactTip
    ) -> None:
        """Its system acknowledges nothing, as behind a cut cable; here because its buffers are full.

        Some systems take a little more each time that they are asked whether there is room again, so a driver may have
        to come twice.
        """

        def came() -> bool:
            with self.connect(server) as new:
                new.sendall(b"\0" + COMMAND)
                with suppress(AssertionError):
                    until(loop, lambda: module.motor_mv == 1234, 0.5)
                return module.motor_mv == 1234

        with socket.socket() as old:
            old.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            with self.connect(server) as other:
                old.connect(other.getpeername())
            old.sendall(b"\0")
            full_s = 0.0
            while full_s < 0.2:
                if len(server.backlog._waiting) < 10:
                    server.send(b"x" * 1000)
                    full_s = 0.0
                loop.serve(0.005)
                server.pump(loop.now())
                full_s += 0.005
            assert any(came() for _ in range(6))
            old.settimeout(2.0)
            with suppress(ConnectionError):
                while old.recv(65536):
                    pass

    def test_the_port_is_not_given_away_while_the_cable_is_out(self, server: SerialServer) -> None:
        server.unplug()
        port = int(server.address.rpartition(":")[2])
        with socket.socket() as other, pytest.raises(OSError, match="in use"):
            other.bind(("127.0.0.1", port))

    def test_a_cable_cannot_be_put_back_where_another_has_come_to_listen(
        self, server: SerialServer, loop: SelectLoop
    ) -> None:
        server.unplug()
        port = int(server.address.rpartition(":")[2])
        with socket.create_server(("127.0.0.1", port)), pytest.raises(ValueError, match=f"port {port}: cannot listen"):
            server.plug()
        server.plug()
        self.open(server, loop).close()

    def test_a_taken_port_is_named(self, server: SerialServer, loop: SelectLoop) -> None:
        port = server.address.rpartition(":")[2]
        with pytest.raises(ValueError, match=f"texture ring: cannot listen on 127.0.0.1:{port}"):
            serve_serial(TactTip(0), loop, f"tcp:127.0.0.1:{port}", "texture ring")


@pytest.mark.parametrize("address", ["", "tty", "tcp:localhost", "tcp:127.0.0.1:99999", "/dev/ttyUSB0"])
def test_an_address_of_another_form_is_refused(address: str) -> None:
    with pytest.raises(ValueError, match="tacttip index"):
        serve_serial(TactTip(0), SelectLoop(), address, "tacttip index")


def test_fingers_are_served_all_or_none() -> None:
    serving, devices = SocketServing(SelectLoop()), {"thumb": TactTip(0), "index": TactTip(1)}
    with ExitStack() as opened, pytest.raises(ValueError, match="fingers says thumb, index"):
        serve_fingers(devices, serving, {"thumb": "pty"}, "tacttip", opened)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        before = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else None
        addresses = {"thumb": "pty", "index": f"tcp:127.0.0.1:{port}"}
        with ExitStack() as opened, pytest.raises(ValueError, match="tacttip index: cannot listen"):
            serve_fingers(devices, serving, addresses, "tacttip", opened)
        if before is not None:
            assert len(os.listdir("/proc/self/fd")) == before
