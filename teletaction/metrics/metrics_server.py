"""Serves metrics over HTTP to this machine, or to clients with the token."""

import hmac
import ipaddress
import logging
import socket
import socketserver
import stat
import sys
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import Any, ClassVar

from prometheus_client import CollectorRegistry
from prometheus_client.exposition import choose_encoder
from prometheus_client.registry import Collector

from common.files.whole_file import read_whole

log = logging.getLogger(__name__)

LEAST_TOKEN = 16
"""Minimum length of a token, characters."""
MOST_CLIENTS = 32
"""Maximum number of clients at a time, each of which has a thread; a further one takes the place of the oldest."""
_LOOK_AT_STOP_S = 0.2
"""Interval between checks of the stop signal, s."""


class ListenProblem(ValueError):
    """The address cannot or must not be served, or the token file is not usable."""


def read_token(path: Path) -> str:
    """Read the token from its file.

    Raises:
        ListenProblem: other users can read the file, or the token is too short or no plain ASCII word.
        OSError: the file cannot be read, or is no regular file.
    """
    content, status = read_whole(path)
    mode = stat.S_IMODE(status.st_mode)
    if mode & 0o077:
        raise ListenProblem(f"{path}: mode {mode:04o} lets others read the token; `chmod 600` it")
    try:
        token = content.decode("ascii").strip()
    except UnicodeDecodeError:
        raise ListenProblem(f"{path}: a token is plain ASCII text") from None
    if len(token) < LEAST_TOKEN or len(token.split()) != 1:
        raise ListenProblem(f"{path}: a token is one word of at least {LEAST_TOKEN} characters")
    return token


class MetricsServer(socketserver.ThreadingTCPServer):
    """An HTTP server with one page, `/metrics`."""

    allow_reuse_address = True
    daemon_threads = True
    request_queue_size = 2 * MOST_CLIENTS

    def __init__(self, listen: str, collector: Collector, token: str | None) -> None:
        """Listen at `HOST:PORT` (`[HOST]:PORT` for IPv6); port 0 takes a free one.

        Raises:
            ListenProblem: the address does not exist, or others can reach it and there is no token.
            OSError: the address is in use, or does not belong to this machine.
        """
        family, address = _resolve(listen)
        self.registry = CollectorRegistry()
        self.registry.register(collector)
        self.token = token
        self._clients: OrderedDict[Any, None] = OrderedDict()
        self.address_family = family
        self.timeout = _LOOK_AT_STOP_S
        if token is None and not ipaddress.ip_address(address[0]).is_loopback:
            raise ListenProblem(f"--listen {listen}: others can reach this address: give a --token-file")
        super().__init__(address, _Handler)

    @property
    def url(self) -> str:
        """Address of the metrics page."""
        host, port = self.server_address[:2]
        name = host.decode() if isinstance(host, bytes) else str(host)
        return f"http://{f'[{name}]' if ':' in name else name}:{port}/metrics"

    def serve(self, stop: Callable[[], bool]) -> None:
        """Answer requests until `stop()` returns True."""
        log.info("metrics at %s%s", self.url, "" if self.token is None else ", with the token only")
        while not stop():
            self.handle_request()

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer in a thread of its own; with too many clients, hang up on the oldest."""
        self._clients[request] = None
        if len(self._clients) > MOST_CLIENTS:
            oldest, _ = self._clients.popitem(last=False)
            with suppress(OSError):  # it has already gone
                oldest.shutdown(socket.SHUT_RDWR)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        self._clients.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: object, client_address: object) -> None:
        """Log a request that failed. It never ends the process."""
        log.warning("a request failed: %r", sys.exception())


class _Handler(BaseHTTPRequestHandler):
    server: MetricsServer
    timeout: ClassVar[float] = 5.0  # s. A silent client holds a thread no longer.

    def do_GET(self) -> None:
        """Send the metrics to an authorized client."""
        if not self._allowed():
            self._answer(HTTPStatus.UNAUTHORIZED, b"token needed\n", {"WWW-Authenticate": "Bearer"})
        elif self.path.partition("?")[0] != "/metrics":
            self._answer(HTTPStatus.NOT_FOUND, b"there is only /metrics\n", {})
        else:
            encode, content_type = choose_encoder(self.headers.get("Accept", ""))
            self._answer(HTTPStatus.OK, encode(self.server.registry), {"Content-Type": content_type})

    def _allowed(self) -> bool:
        if self.server.token is None:
            return True
        given = self.headers.get("Authorization", "")
        return hmac.compare_digest(given.encode("utf-8", "replace"), f"Bearer {self.server.token}".encode())

    def _answer(self, code: HTTPStatus, body: bytes, headers: dict[str, str]) -> None:
        self.send_response(code)
        for name, value in {"Content-Type": "text/plain", **headers, "Content-Length": str(len(body))}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def version_string(self) -> str:
        return "teletaction"

    def log_message(self, format: str, *args: object) -> None:
        log.debug(format, *args)


def _resolve(listen: str) -> tuple[socket.AddressFamily, tuple[str, int]]:
    host, colon, port = listen.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not (colon and host and port.isascii() and port.isdigit() and int(port) <= 65535):
        raise ListenProblem(f"--listen {listen!r}: expected HOST:PORT, such as 127.0.0.1:9634")
    try:
        family, _, _, _, address = socket.getaddrinfo(host, int(port), type=socket.SOCK_STREAM)[0]
    except OSError as error:
        raise ListenProblem(f"--listen {listen}: {error.strerror}") from None
    return family, (str(address[0]), int(port))
