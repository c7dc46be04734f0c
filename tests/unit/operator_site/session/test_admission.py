"""A refused key is reported once, and asked for until the remote site trusts it; a refusal ends no process."""

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import suppress

import pytest

from common.fingers import FINGERS
from common.link.capabilities import capabilities
from common.link.keys import TrustedKeys, fingerprint, load_keys
from common.link.link import OperatorLink, RemoteLink
from common.wire.streams import SITE_STREAMS
from operator_site.session.admission import Admission
from operator_site.session.session_client import SessionClient
from remote_site.session.session_server import SessionServer
from tests.conftest import Keys
from tests.unit.common.link.links import operator_link, remote_link
from tests.waiting import wait_until

GREETING = b"\xff" + bytes(8) + b"\x7f\x03\x00" + b"CURVE".ljust(20, b"\0") + b"\x01" + bytes(31)
REFUSAL = b"\x04\x0a\x05ERROR\x03400"
"""A ZMTP command that anybody can send: nothing in it is encrypted."""


class Refuser:
    """Answers every connection at the remote site's address with a refusal; it has no key."""

    def __init__(self, base_port: int) -> None:
        self.refused = 0
        ports = [base_port + stream.port for stream in SITE_STREAMS.values()]
        self._sockets = [socket.create_server(("127.0.0.1", port)) for port in ports]
        for listening in self._sockets:
            threading.Thread(target=self._serve, args=(listening,), daemon=True).start()

    def _serve(self, listening: socket.socket) -> None:
        with suppress(OSError):
            while True:
                connection = listening.accept()[0]
                with connection, suppress(OSError):
                    connection.settimeout(1.0)
                    connection.sendall(GREETING)
                    received = b""
                    while len(received) < len(GREETING) + 200:
                        received += connection.recv(1000)
                    connection.sendall(REFUSAL)
                    self.refused += 1
                    connection.recv(1)

    def close(self) -> None:
        for listening in self._sockets:
            listening.shutdown(socket.SHUT_RDWR)
            listening.close()


def admitting(link: OperatorLink) -> tuple[SessionClient, Admission]:
    client = SessionClient(link, capabilities(FINGERS, 500.0), 0.15, want_engaged=False)
    return client, Admission(client, link, "remote.example:5600")


@pytest.fixture
def operator(keys: Keys, base_port: int) -> Iterator[OperatorLink]:
    with operator_link(keys, base_port) as link:
        yield link


@pytest.fixture
def remote(keys: Keys, base_port: int) -> Iterator[RemoteLink]:
    with remote_link(keys, base_port) as link:
        yield link


def test_a_host_at_the_remote_sites_address_cannot_end_a_site(
    keys: Keys, base_port: int, operator: OperatorLink, caplog: pytest.LogCaptureFixture
) -> None:
    client, admission = admitting(operator)
    refuser = Refuser(base_port)
    refusals = []
    for refused in (4, 8, 12):
        wait_until(lambda refused=refused: refuser.refused >= refused, "it is not asked again")  # type: ignore[misc]
        time.sleep(0.05)  # the monitor's thread
        admission.each_second()
        refusals.append(client.refusal)
    refuser.close()
    assert len(set(refusals)) == 1
    assert refusals[0].startswith(
        "remote.example:5600: the remote site does not trust this site's key as an operator's"
    )
    assert len([text for text in caplog.messages if "does not trust" in text]) == 1
    with remote_link(keys, base_port) as remote:
        assert_admitted(client, admission, remote)


def assert_admitted(client: SessionClient, admission: Admission, remote: RemoteLink) -> None:
    """Connect once a second, as a site does, until there is a session without a refusal."""
    server = SessionServer(remote, capabilities(FINGERS, 250.0), 0.15)
    due_s = 0.0

    def admitted() -> bool:
        nonlocal due_s
        now_s = time.monotonic()
        server.step(time.monotonic_ns(), "")
        client.step(time.monotonic_ns(), "")
        if now_s >= due_s:
            due_s = now_s + 1.0
            admission.each_second()
        return client.session.ident != 0 and not client.refusal

    wait_until(admitted, lambda: client.refusal)


def test_a_site_that_was_never_trusted_is_admitted_once_it_is(
    keys: Keys, operator: OperatorLink, remote: RemoteLink
) -> None:
    trusted = TrustedKeys(keys.remote)
    trusted.revoke("operator")
    client, admission = admitting(operator)

    def reported() -> bool:
        admission.each_second()
        return bool(client.refusal)

    wait_until(reported, every_s=0.1)
    trusted.trust("operator", load_keys(keys.operator).public)
    assert_admitted(client, admission, remote)


def test_a_server_of_another_key_is_named_until_the_right_one_answers(
    keys: Keys, base_port: int, operator: OperatorLink, caplog: pytest.LogCaptureFixture
) -> None:
    """As after a new key of the remote site, or a key that was copied wrongly: neither side would say anything."""
    client, admission = admitting(operator)

    def reported() -> bool:
        admission.each_second()
        return bool(client.refusal)

    with RemoteLink("127.0.0.1", base_port, load_keys(keys.stranger), TrustedKeys(keys.remote)):
        wait_until(reported, every_s=0.1)
        time.sleep(0.2)
        admission.each_second()
    expected = fingerprint(load_keys(keys.remote).public)
    assert client.refusal.startswith(
        f"remote.example:5600: what answers there does not prove the remote site's key {expected}:"
    )
    assert len([text for text in caplog.messages if expected in text]) == 1
    with remote_link(keys, base_port) as remote:
        assert_admitted(client, admission, remote)


def test_an_absent_remote_site_is_not_accused(operator: OperatorLink) -> None:
    client, admission = admitting(operator)
    for _ in range(10):
        time.sleep(0.05)
        admission.each_second()
    assert (client.refusal, operator.unproven) == ("", 0)
