"""Open and serve listening TCP ports without blocking."""

import socket


def listen_tcp(host: str, port: int, what: str) -> socket.socket:
    """Listen on an address without blocking.

    Args:
        host: name or address of one of this machine's interfaces.
        port: TCP port; 0 lets the system choose one.
        what: name of the service, for the error.

    Raises:
        ValueError: the address is taken or is not this machine's.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen()
        listener.setblocking(False)
    except (OSError, OverflowError) as error:
        listener.close()
        raise ValueError(f"{what}: cannot listen on {host}:{port}: {error}; choose another port") from None
    return listener


def accept_tcp(listener: socket.socket, buffer_bytes: int) -> socket.socket | None:
    """Return the next client, set up for small fast messages; None if it has already gone.

    The kernel's send buffer is small, so that a slow reader gets no old messages.
    """
    try:
        client, _ = listener.accept()
    except OSError:
        return None
    client.setblocking(False)
    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, buffer_bytes)
    return client


def receive_tcp(client: socket.socket, most: int) -> bytes | None:
    """Return the bytes of a client: empty once it has gone, None if there are none yet.

    The device's next report acknowledges them, within 10 ms. A client with Nagle's algorithm holds its next message
    back until then.
    """
    try:
        return client.recv(most)
    except BlockingIOError:
        return None
    except OSError:
        return b""
