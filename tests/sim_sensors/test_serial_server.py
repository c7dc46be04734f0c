import os
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import serial

from common.framing import FrameReader, encode_frame
from common.serial_messages import MessageId, TactTipCommand, TactTipState
from sim_sensors.backlog import Backlog
from sim_sensors.select_loop import SelectLoop
from sim_sensors.serial_server import SerialServer, serve_fingers, serve_serial
from sim_sensors.tacttip import TactTip

COMMAND = encode_frame(MessageId.TACTTIP_COMMAND, 0, TactTipCommand(1234, -500).encode())


def until(loop: SelectLoop, done: Callable[[], object], seconds: float = 2.0) -> bool:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        loop.serve(0.002)
        if done():
            return True
    return False


class LineContract:
    """What a served module promises, whatever the line."""

    address: str

    @pytest.fixture
    def loop(self) -> SelectLoop:
        return SelectLoop()

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
        loop.serve(0.01)
        return port

    def test_a_driver_is_answered(self, server: SerialServer, loop: SelectLoop) -> None:
        reader = FrameReader()
        seen: set[int] = set()
        with self.open(server, loop) as port:
            port.write(encode_frame(MessageId.IDENTIFY, 0))

            def identified() -> bool:
                seen.update(frame.message_id for frame in reader.feed(port.read(4096)))
                return MessageId.IDENTITY in seen

            assert until(loop, identified)

    def test_every_byte_value_passes_unchanged(self, server: SerialServer, loop: SelectLoop, module: TactTip) -> None:
        with self.open(server, loop) as port:
            port.write(COMMAND)
            assert until(loop, lambda: module.motor_mv == 1234 and module.peltier_permille == -500)
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
                assert until(loop, lambda wanted=motor_mv: module.motor_mv == wanted)  # type: ignore[misc]
                port.write(COMMAND[:4])  # and dies in the middle of a frame
            loop.serve(0.01)
            server.pump(loop.now())

    def test_a_driver_that_never_reads_holds_nothing_up(self, server: SerialServer, loop: SelectLoop) -> None:
        with self.open(server, loop):
            start = time.monotonic()
            for n in range(30_000):
                server._send(b"x" * 100)
                if n % 1000 == 0:
                    loop.serve(0.0)
            assert time.monotonic() - start < 2.0
            assert server.backlog.dropped > 1000


class TestPty(LineContract):
    address = "pty"


class TestTcp(LineContract):
    address = "tcp:127.0.0.1:0"

    def test_a_new_client_takes_over_from_a_half_dead_one(
        self, server: SerialServer, loop: SelectLoop, module: TactTip
    ) -> None:
        with self.open(server, loop) as old, self.open(server, loop) as new:
            new.write(COMMAND)
            assert until(loop, lambda: module.motor_mv == 1234)

            def hung_up() -> bool:
                try:
                    old.read(100)
                except serial.SerialException:
                    return True
                return False

            assert until(loop, hung_up)

    def test_a_taken_port_is_named(self, server: SerialServer, loop: SelectLoop) -> None:
        port = server.address.rpartition(":")[2]
        with pytest.raises(ValueError, match=f"texture ring: cannot listen on 127.0.0.1:{port}"):
            serve_serial(TactTip(0), loop, f"tcp:127.0.0.1:{port}", "texture ring")


@pytest.mark.parametrize("address", ["", "tty", "tcp:localhost", "tcp:127.0.0.1:99999", "/dev/ttyUSB0"])
def test_an_address_of_another_form_is_refused(address: str) -> None:
    with pytest.raises(ValueError, match="tacttip index"):
        serve_serial(TactTip(0), SelectLoop(), address, "tacttip index")


def test_fingers_are_served_all_or_none() -> None:
    loop = SelectLoop()
    with pytest.raises(ValueError, match="fingers says thumb, index"):
        serve_fingers({"thumb": TactTip(0), "index": TactTip(1)}, loop, {"thumb": "pty"}, "tacttip")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        before = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else None
        with pytest.raises(ValueError, match="tacttip index: cannot listen"):
            serve_fingers(
                {"thumb": TactTip(0), "index": TactTip(1)},
                loop,
                {"thumb": "pty", "index": f"tcp:127.0.0.1:{port}"},
                "tacttip",
            )
        if before is not None:
            assert len(os.listdir("/proc/self/fd")) == before


def test_a_backlog_drops_whole_messages_oldest_first_but_never_half_of_one() -> None:
    backlog, written = Backlog(10), bytearray()

    def send_three(data: bytes) -> int:
        if len(written) >= 3:
            raise BlockingIOError
        written.extend(data[:3])
        return 3

    backlog.push(b"aaaaa")
    backlog.write(send_three)
    backlog.push(b"bbbbb")
    backlog.push(b"ccccc")
    backlog.push(b"ddd")
    assert backlog.dropped == 1

    def send_all(data: bytes) -> int:
        written.extend(data)
        return len(data)

    backlog.write(send_all)
    assert bytes(written) == b"aaaaacccccddd"
