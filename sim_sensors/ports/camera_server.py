"""Emulate a network camera that sends YUV4MPEG2, uncompressed pictures in order, to each client over TCP."""

import math
import socket
from collections.abc import Callable

from common.config.simulation_models import SimCameraConfig
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.tcp_port import TcpPort, ended, tcp_address

_BUFFER_BYTES = 1 << 21
"""Send buffer of a client in the kernel: some pictures."""
MOST_CLIENTS = 16
"""Maximum number of clients; further ones are refused."""
_FRAME = b"FRAME\n"


class _Client:
    """One client; a picture that it has not taken when the next one is due is completed, and the next one omitted."""

    def __init__(self, connection: socket.socket, header: bytes) -> None:
        self.connection = connection
        self.unsent = memoryview(header)
        self.gone = False

    def send(self) -> None:
        """Send what the connection takes."""
        try:
            while self.unsent:
                self.unsent = self.unsent[self.connection.send(self.unsent) :]
        except BlockingIOError:
            return
        except OSError:
            self.gone = True


class CameraServer:
    """Emulated camera.

    Attributes:
        frozen: fault; the camera stays connected and sends nothing.
        omitted: number of pictures that a slow client did not get.
    """

    def __init__(
        self, config: SimCameraConfig, sockets: SelectLoop, draw: Callable[[float], bytes], powered_s: float
    ) -> None:
        """Listen.

        Args:
            config: address, size and rate.
            sockets: event loop that watches the port.
            draw: returns the picture at a time, s: its planes, YUV 4:2:0.
            powered_s: time of the first picture, s.

        Raises:
            ValueError: the address is malformed, taken or not this machine's.
        """
        place = tcp_address(config.port)
        if place is None:
            raise ValueError(f"camera: {config.port!r} is not tcp:HOST:PORT")
        self.frozen = False
        self.omitted = 0
        self._draw, self._period_s, self._due_s = draw, 1.0 / config.rate_hz, powered_s
        self._header = f"YUV4MPEG2 W{config.width} H{config.height} F{config.rate_hz}:1 Ip A1:1 C420jpeg\n".encode()
        self._clients: list[_Client] = []
        self._port = TcpPort(sockets, *place, "camera", buffer_bytes=_BUFFER_BYTES, greet=self._greet)
        self.address = f"tcp://{place[0]}:{self._port.number}"

    def _greet(self, connection: socket.socket, now_s: float) -> None:
        if len(self._clients) >= MOST_CLIENTS:
            connection.close()
        else:
            self._clients.append(_Client(connection, self._header))

    def pump(self, now_s: float) -> None:
        """Send the picture that is due at `now_s`, s, if there is a client and no fault."""
        if now_s >= self._due_s:
            self._due_s += self._period_s * math.ceil((now_s - self._due_s) / self._period_s + 1e-9)
            ready = [client for client in self._clients if not client.unsent]
            self.omitted += len(self._clients) - len(ready)
            if ready and not self.frozen:
                picture = _FRAME + self._draw(now_s)
                for client in ready:
                    client.unsent = memoryview(picture)
        for client in self._clients:
            client.send()
        self._keep([client for client in self._clients if not (client.gone or ended(client.connection))])

    def close(self) -> None:
        """Disconnect all clients and release the port."""
        self._keep([])
        self._port.close()

    def _keep(self, clients: list[_Client]) -> None:
        """Disconnect all other clients."""
        for client in self._clients:
            if client not in clients:
                client.connection.close()
        self._clients = clients
