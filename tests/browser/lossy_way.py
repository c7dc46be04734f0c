"""A way from the browser to the stage that can lose its present connections, unnoticed by either end."""

import socket
import threading
from contextlib import suppress
from urllib.parse import urlsplit

_CHUNK = 1 << 16


class LossyWay:
    """Relays TCP connections in threads.

    Attributes:
        url: where the page is on this way.
    """

    def __init__(self, url: str) -> None:
        """Lead to the server at `url`."""
        parts = urlsplit(url)
        self._to = parts.hostname or "", parts.port or 0
        self._lost: set[socket.socket] = set()
        self._open: set[socket.socket] = set()
        self._server = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._server.getsockname()[1]}/"
        threading.Thread(target=self._accept, daemon=True).start()

    def lose(self) -> None:
        """Carry nothing more on the present connections, and leave them open; new ones get through."""
        self._lost |= self._open

    def close(self) -> None:
        """End all connections."""
        for end in (self._server, *self._open):
            with suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                near, _ = self._server.accept()
                far = socket.create_connection(self._to)
                self._open |= {near, far}
                for source, target in ((near, far), (far, near)):
                    threading.Thread(target=self._relay, args=(source, target), daemon=True).start()

    def _relay(self, source: socket.socket, target: socket.socket) -> None:
        with suppress(OSError):
            while data := source.recv(_CHUNK):
                if source not in self._lost:
                    target.sendall(data)
            if source not in self._lost:
                target.shutdown(socket.SHUT_WR)
