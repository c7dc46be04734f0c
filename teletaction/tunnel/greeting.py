"""Lines with which a connection to the rendezvous begins, before it carries bytes.

The rendezvous sends a number that was never used before. The end of a tunnel answers with its request and a proof that
it knows the room's secret (HMAC-SHA256, RFC 2104, over number and request). The secret itself is never sent.
"""

import hmac
import re
import secrets
from typing import NamedTuple

LONGEST_LINE = 200
"""Maximum length of a line, bytes."""
READY = 8
"""Number of connections that a room's remote end keeps waiting: the link of an operator and an observer has 8."""
REACHED = "joined"
"""Line of the rendezvous to the operator's end: bytes follow."""
_HELLO = "teletaction-rendezvous 1 "
_STREAM, _REFUSED = "stream ", "refused "
_REQUEST = re.compile(
    r"(?P<ask>serve (?P<room>[a-z0-9-]{1,32})|reach (?P<to>[a-z0-9-]{1,32}) (?P<port>[0-9])) (?P<proof>[0-9a-f]{64})"
)


class Request(NamedTuple):
    """Request of a tunnel's end.

    Attributes:
        room: name of the room.
        port: number of the stream's port, counted from the link's first; None for the remote site's end, which waits.
        text: the request as it is proved.
        proof: proof that the sender knows the room's secret.
    """

    room: str
    port: int | None
    text: str
    proof: str


def new_hello() -> tuple[str, str]:
    """Return the first line of a new connection, and its number."""
    number = secrets.token_hex(16)
    return _HELLO + number, number


def read_hello(line: str) -> str:
    """Return the number in the first line; raises ValueError for another line."""
    if not line.startswith(_HELLO):
        raise ValueError("no rendezvous of this version answers there")
    return line.removeprefix(_HELLO)


def request(secret: bytes, number: str, room: str, port: int | None) -> str:
    """Return the line that asks to serve a room, or to reach the stream of a port of it."""
    text = f"serve {room}" if port is None else f"reach {room} {port}"
    return f"{text} {_proof(secret, number, text)}"


def read_request(line: str) -> Request:
    """Return the request in a line; raises ValueError for another line."""
    if (found := _REQUEST.fullmatch(line)) is None:
        raise ValueError("no request")
    port = found["port"]
    return Request(found["room"] or found["to"], None if port is None else int(port), found["ask"], found["proof"])


def is_proved(asked: Request, secret: bytes, number: str) -> bool:
    """Return whether the sender of a request knows the secret."""
    return hmac.compare_digest(asked.proof.encode(), _proof(secret, number, asked.text).encode())


def stream_line(port: int) -> str:
    """Return the line that asks the remote site's end to connect to the stream of a port."""
    return f"{_STREAM}{port}"


def read_stream(line: str) -> int:
    """Return the port in the rendezvous's answer.

    Raises:
        ValueError: the rendezvous refuses; the message is its reason.
    """
    if line.startswith(_STREAM) and (port := line.removeprefix(_STREAM)).isascii() and port.isdigit():
        return int(port)
    raise ValueError(refusal(line))


def refused(reason: str) -> str:
    """Return the line that refuses a request."""
    return f"{_REFUSED}{reason}"


def refusal(line: str) -> str:
    """Return the reason of a refusal, or that a line is none."""
    return line.removeprefix(_REFUSED) if line.startswith(_REFUSED) else "the rendezvous sent an unknown answer"


def _proof(secret: bytes, number: str, text: str) -> str:
    return hmac.digest(secret, f"{number} {text}".encode(), "sha256").hex()
