"""Controls access to the page: open on loopback by default, elsewhere by token over TLS."""

import hmac
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args
from urllib.parse import urlsplit

from common.config.page_models import WebConfig
from common.files.whole_file import read_whole
from common.link.host_name import bracketed, is_loopback

Role = Literal["act", "observe"]
LEAST_TOKEN = 32
"""Smallest length of a token, characters; `openssl rand -hex 32` makes one of 64."""
COOKIE = "teletaction"
"""Name of the cookie that holds the token."""
_PORTS = {"http": 80, "https": 443}
"""Port of each scheme, which browsers leave out of an origin."""


class AccessProblem(ValueError):
    """The access settings are unsafe or invalid; the message gives the remedy."""


@dataclass(frozen=True, slots=True)
class Visitor:
    """A user who may open the page, with a name and a role."""

    name: str
    role: Role


class Access:
    """Checks tokens, and the addresses that requests name."""

    def __init__(self, config: WebConfig):
        """Read the configuration.

        Raises:
            AccessProblem: the page would be open to a network without tokens or TLS, or a setting is invalid.
        """
        self._loopback = is_loopback(config.bind)
        self._tokens = {} if config.tokens is None else read_tokens(config.tokens)
        encrypted = config.certificate is not None or config.behind_proxy
        self.secure = encrypted
        """Whether browsers reach the page over TLS, here or at a proxy."""
        self._origin = None if config.address is None else _origin(config.address)
        if not self._loopback and not self._tokens:
            raise AccessProblem(f"{config.bind} is open to a network: set `tokens`, or bind to 127.0.0.1")
        if not self._loopback and not encrypted:
            raise AccessProblem(
                f"{config.bind} is open to a network: set `certificate` and `certificate_key`, or `behind_proxy = "
                "true` if a reverse proxy serves TLS, or bind to 127.0.0.1"
            )
        if config.behind_proxy and not self._tokens:
            raise AccessProblem("behind a proxy all visitors come from loopback: set `tokens`")

    def visitor(self, token: str | None, role: str | None = None) -> Visitor | None:
        """Return the visitor with this token, or None if it is unknown.

        Without configured tokens every visitor is accepted, in the requested role.
        """
        if not self._tokens:
            return Visitor("console", "observe" if role == "observe" else "act")
        found = None
        for known, visitor in self._tokens.items():  # compare with all tokens: the time must not reveal a match
            if hmac.compare_digest(known.encode(), (token or "").encode()):
                found = visitor
        return found

    def expected(self, host: str | None, origin: str | None) -> bool:
        """Return whether a request is addressed to this page and comes from it, if the browser names its origin.

        They are the headers `Host` and `Origin`; browsers send the second with every websocket.
        """
        if host is None:
            return False
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False  # such as half of an IPv6 address
        if self._loopback and self._origin is None and not is_loopback(name):
            return False  # DNS rebinding: a foreign name that resolves to this machine
        if origin is None:
            return True
        if self._origin is not None:
            return origin == self._origin
        return origin == f"{'https' if self.secure else 'http'}://{host}"


def read_tokens(path: Path) -> dict[str, Visitor]:
    """Read tokens and their visitors from lines `NAME act|observe TOKEN`; skip empty lines and `#` comments.

    Raises:
        AccessProblem: the file cannot be read, is readable by others, has an invalid line, or has no token.
    """
    try:
        content, status = read_whole(path)
        lines = content.decode("utf-8").splitlines()
    except OSError as error:
        raise AccessProblem(f"{path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise AccessProblem(f"{path}: not UTF-8") from None
    if status.st_mode & 0o077:
        raise AccessProblem(f"{path}: readable by others: chmod 600 {path}")
    found: dict[str, Visitor] = {}
    for number, line in enumerate(lines, 1):
        parts = line.split()
        if not parts or parts[0].startswith("#"):
            continue
        if len(parts) != 3 or parts[1] not in get_args(Role) or len(parts[2]) < LEAST_TOKEN:
            raise AccessProblem(f"{path}:{number}: expected NAME act|observe TOKEN of {LEAST_TOKEN} characters or more")
        if parts[2] in found:
            raise AccessProblem(f"{path}:{number}: this token is another visitor's")
        found[parts[2]] = Visitor(parts[0], "act" if parts[1] == "act" else "observe")
    if not found:
        raise AccessProblem(f"{path}: no token in this file")
    return found


def _origin(address: str) -> str:
    """Return the origin of an address as browsers write it: in lower case, without the usual port of its scheme."""
    with suppress(ValueError):  # half of an IPv6 address, or a port that is no number
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port
        if parts.scheme in _PORTS and host and parts.path in ("", "/"):
            return f"{parts.scheme}://{bracketed(host)}" + ("" if port in (None, _PORTS[parts.scheme]) else f":{port}")
    raise AccessProblem(f"address {address!r}: expected such as https://console.example")
