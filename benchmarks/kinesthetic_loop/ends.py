"""Device ends of the kinesthetic loop's bus; each reports by the device's own clock when forces reached it.

One is the emulated exoskeleton in a thread of this process, on python-can's virtual bus. The other is the simulator's
real process behind its socketcand gateway. There a second connection to the bus listens to what arrives.
"""

import math
import socket
import sys
import threading
import time
from itertools import count
from pathlib import Path
from subprocess import DEVNULL, Popen
from tempfile import TemporaryDirectory

import can
import numpy as np

from common.buses.can_address import CanAddress
from common.buses.can_frames import database
from common.config.file import to_toml
from common.config.simulation_models import SimOperatorConfig
from sim_sensors.devices.exoskeleton import Exoskeleton
from teletaction.session.demo_ports import HOST, free_port_block

FORCES = int(database().get_message_by_name("FingerForces").frame_id)
FRAME_S = 0.002
_OPEN_S = 20.0
_names = count()


class VirtualEnd:
    """The emulated exoskeleton in a thread, with fingers that press 2 mm deep twice a second."""

    def __init__(self) -> None:
        channel = f"kinesthetic-{next(_names)}"
        self.address = CanAddress(interface="virtual", channel=channel)
        self._bus = can.Bus(interface="virtual", channel=channel)
        self._arrivals_s: list[float] = []
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def keep_up(self) -> None:
        """Do nothing; the thread keeps up by itself."""

    def arrivals_s(self) -> list[float]:
        """Time at which each frame of forces reached the node, s."""
        return self._arrivals_s

    def close(self) -> None:
        """End the thread and the bus."""
        self._ended.set()
        self._thread.join()
        self._bus.shutdown()

    def _run(self) -> None:
        node, fingers = Exoskeleton(), np.arange(5)
        due_s = time.time()  # the clock that the virtual bus stamps with
        while not self._ended.is_set():
            now_s = time.time()
            if now_s >= due_s:
                due_s = max(due_s + FRAME_S, now_s)
                node.measure(0.0, 0.0, 0.002 * np.sin(4.0 * math.pi * now_s + fingers))
                for frame_id, data in node.take_turn():
                    self._bus.send(can.Message(arbitration_id=frame_id, data=data, is_extended_id=False))
            message = self._bus.recv(max(0.0, due_s - time.time()))
            if message is not None:
                node.feed(message.arbitration_id, bytes(message.data), time.time())
                if message.arbitration_id == FORCES:
                    self._arrivals_s.append(time.time())


class GatewayEnd:
    """The simulator's process with a hand that works on a scene; a listener receives every frame on its bus."""

    def __init__(self) -> None:
        self._folder = TemporaryDirectory(prefix="kinesthetic-")
        first = free_port_block(2)
        self.address = CanAddress(interface="socketcand", host=HOST, port=first)
        tacttip = f"tcp:{HOST}:{first + 1}"
        config = SimOperatorConfig(fingers=("index",), tacttip={"index": tacttip}, can_port=first)
        path = Path(self._folder.name) / "sim-operator.toml"
        path.write_text(to_toml(config), "utf-8")
        command = [sys.executable, "-m", "sim_sensors", "operator", "--config", str(path)]
        self._process = Popen(command, stdin=DEVNULL, stdout=DEVNULL, stderr=DEVNULL)
        self._heard: list[bytes] = []
        self._listener = self._listen(first)

    def keep_up(self) -> None:
        """Take the frames that came over the bus since the last call."""
        try:
            self._heard.append(self._listener.recv(1 << 20))
        except BlockingIOError:
            return

    def arrivals_s(self) -> list[float]:
        """Time at which each frame of forces reached the simulator's gateway, s; NaN for one that is missing there."""
        self.keep_up()
        frames = (frame.split() for frame in b"".join(self._heard).split(b">"))
        forces = [words for words in frames if len(words) == 5 and int(words[2], 16) == FORCES]
        arrived_s: list[float] = []
        for words in forces:
            counter = int(words[4][12:14], 16) >> 4
            arrived_s += [math.nan] * ((counter - len(arrived_s)) & 0xF)
            arrived_s.append(float(words[3]))
        return arrived_s

    def close(self) -> None:
        """End the process."""
        self._listener.close()
        self._process.terminate()
        self._process.wait()
        self._folder.cleanup()

    def _listen(self, port: int) -> socket.socket:
        deadline_s = time.monotonic() + _OPEN_S
        while True:
            try:
                connection = socket.create_connection((HOST, port), timeout=_OPEN_S)
                break
            except ConnectionRefusedError:
                if time.monotonic() > deadline_s or self._process.poll() is not None:
                    self._process.kill()
                    raise
                time.sleep(0.05)
        for request in (b"", b"< open can0 >", b"< rawmode >"):
            connection.sendall(request)
            connection.recv(64)
        connection.setblocking(False)
        return connection


DeviceEnd = VirtualEnd | GatewayEnd
"""The other end of the loop's bus."""
