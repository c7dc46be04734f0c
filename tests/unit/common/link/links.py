"""Both ends of a link over loopback, and whether something gets from one to the other."""

import socket
from pathlib import Path

import pytest

from common.link.keys import Role, TrustedKeys, load_keys
from common.link.link import OperatorLink, RemoteLink
from tests.conftest import Keys
from tests.waiting import wait_until


def has_ipv6() -> bool:
    try:
        with socket.create_server(("::1", 0), family=socket.AF_INET6):
            return True
    except OSError:
        return False


needs_ipv6 = pytest.mark.skipif(not has_ipv6(), reason="this machine has no IPv6 on loopback")


def remote_link(keys: Keys, base_port: int, host: str = "127.0.0.1") -> RemoteLink:
    return RemoteLink(host, base_port, load_keys(keys.remote), TrustedKeys(keys.remote))


def operator_link(
    keys: Keys, base_port: int, folder: Path | None = None, host: str = "127.0.0.1", role: Role = Role.PARTNER
) -> OperatorLink:
    """An operator's end; `folder` holds the key that it shows, its own where none is named."""
    remote_key = load_keys(keys.remote).public
    return OperatorLink(host, base_port, load_keys(folder or keys.operator), remote_key, role)


def ask(remote: RemoteLink, operator: OperatorLink, question: bytes = b"?", stream: str = "control") -> None:
    """Return when a request has reached the remote site and its answer has come back."""

    def asked_and_answered() -> bool:
        operator.send(stream, question)
        for sender, packet in remote.requests(stream):
            remote.answer(stream, sender.who, packet + b"!")
        return question + b"!" in operator.receive(stream)

    wait_until(asked_and_answered, "no answer came", every_s=0.001)


def touched(remote: RemoteLink, operator: OperatorLink, packet: bytes = b"t") -> bool:
    """Whether a touch that is sent now has come."""
    remote.send_latest("touch", packet)
    return operator.receive_latest("touch") == packet


def exchange(remote: RemoteLink, operator: OperatorLink) -> None:
    """Return when something has crossed on each of the operator's streams."""
    ask(remote, operator)
    ask(remote, operator, b"beat", "heartbeat")

    def moved() -> bool:
        operator.send_latest("motion", b"m")
        return remote.receive_latest("motion") == b"m"

    wait_until(moved)
    wait_until(lambda: touched(remote, operator))
