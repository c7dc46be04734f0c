import socket
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from common.link.keys import Role, TrustedKeys, load_keys
from teletaction.tunnel import rendezvous
from teletaction.tunnel.greeting import READY, read_hello, request
from teletaction.tunnel.room_secret import create_secret, read_secret
from tests.conftest import Keys
from tests.ports import free_ports
from tests.unit.common.link.links import ask, exchange, operator_link, remote_link, touched
from tests.unit.common.link.listener import CHANGES, Listener
from tests.unit.teletaction.tunnel.tunnels import ROOM, Way
from tests.waiting import wait_until


@pytest.fixture
def way(tmp_path: Path, base_port: int) -> Way:
    return Way(tmp_path, base_port, free_ports())


@pytest.fixture
def ends() -> Iterator[ExitStack]:
    with ExitStack() as ends:
        yield ends


@pytest.mark.long
def test_every_stream_crosses_and_both_sites_only_connect_outwards(keys: Keys, way: Way, ends: ExitStack) -> None:
    TrustedKeys(keys.remote).trust("colleague", load_keys(keys.stranger).public, Role.OBSERVER)
    for part in (way.rendezvous(), way.end("remote"), way.end("operator")):
        ends.enter_context(part)
    remote = ends.enter_context(remote_link(keys, way.remote_port))
    operator = ends.enter_context(operator_link(keys, way.operator_port))
    observer = ends.enter_context(operator_link(keys, way.operator_port, keys.stranger, role=Role.OBSERVER))
    exchange(remote, operator)
    ask(remote, observer)
    ask(remote, observer, b"beat", "heartbeat")

    def observed() -> bool:
        remote.send_latest("observed", b"o")
        return observer.receive_latest("observed") == b"o"

    wait_until(observed)
    wait_until(lambda: way.status("rendezvous")["rooms"][ROOM]["joined"] == 7)


@pytest.mark.long
def test_whoever_carries_the_bytes_reads_nothing_and_adds_nothing(keys: Keys, way: Way, ends: ExitStack) -> None:
    listener = Listener(way.port)
    for part in (way.rendezvous(), listener.listening(), way.end("remote", port=listener.port), way.end("operator")):
        ends.enter_context(part)
    remote = ends.enter_context(remote_link(keys, way.remote_port))
    operator = ends.enter_context(operator_link(keys, way.operator_port))
    wait_until(lambda: touched(remote, operator, b"a secret of the patient"))
    assert len(listener.heard) > 1000
    assert b"secret of" not in listener.heard
    assert read_secret(way.secret) not in listener.heard
    assert load_keys(keys.operator).public.encode() not in listener.heard

    got: set[bytes | None] = set()

    def exchanged(pieces: int) -> bool:
        operator.key_refused()  # connects again
        remote.send_latest("touch", b"a secret of the patient")
        got.add(operator.receive_latest("touch"))
        return listener.pieces > pieces

    for change in CHANGES:
        # The lines at the beginning stay whole: what follows them is to be refused by the sites.
        listener.change = lambda data, change=change: data if data.endswith(b"\n") else change(data)  # type: ignore[misc]
        end = listener.pieces + 4
        wait_until(lambda end=end: exchanged(end))  # type: ignore[misc]
        listener.change = bytes
        assert got <= {None, b"a secret of the patient", b"sound again"}
        wait_until(lambda: operator.key_refused() or touched(remote, operator, b"sound again"))
        got.clear()


@pytest.mark.long
def test_the_rendezvous_may_end_and_return(keys: Keys, way: Way, ends: ExitStack) -> None:
    for part in (way.end("remote"), way.end("operator")):
        ends.enter_context(part)
    remote = ends.enter_context(remote_link(keys, way.remote_port))
    operator = ends.enter_context(operator_link(keys, way.operator_port))
    for _ in range(2):
        with way.rendezvous():
            wait_until(lambda: touched(remote, operator))
            ask(remote, operator)
        wait_until(lambda: not operator.send("control", b"anybody?"))
        wait_until(lambda: "connection refused" in way.status("remote")["missing"])


@pytest.mark.long
def test_the_operator_may_come_first(keys: Keys, way: Way, ends: ExitStack) -> None:
    for part in (way.rendezvous(), way.end("operator")):
        ends.enter_context(part)
    operator = ends.enter_context(operator_link(keys, way.operator_port))
    wait_until(lambda: "the remote site is not there" in way.status("operator").get("missing", ""))
    ends.enter_context(way.end("remote"))
    remote = ends.enter_context(remote_link(keys, way.remote_port))
    wait_until(lambda: touched(remote, operator))
    wait_until(lambda: way.status("operator").get("missing", "") == "")


@pytest.mark.long
def test_a_wrong_secret_opens_no_room(keys: Keys, way: Way, ends: ExitStack) -> None:
    other = way.folder / "other"
    create_secret(other)
    for part in (way.rendezvous(), way.end("remote"), way.end("operator", secret=other)):
        ends.enter_context(part)
    ends.enter_context(remote_link(keys, way.remote_port))
    operator = ends.enter_context(operator_link(keys, way.operator_port))
    wait_until(lambda: "room and secret do not match" in way.status("operator").get("missing", ""))
    assert not operator.send("control", b"?")


@pytest.mark.long
def test_silent_and_talkative_strangers_keep_nobody_out(
    keys: Keys, way: Way, ends: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rendezvous, "MOST_STRANGERS", 4)
    monkeypatch.setattr(rendezvous, "GREETING_S", 0.5)
    for part in (way.rendezvous(), way.end("remote"), way.end("operator")):
        ends.enter_context(part)
    remote = ends.enter_context(remote_link(keys, way.remote_port))
    wait_until(lambda: way.status("remote").get("ready") == 8)

    def stranger() -> socket.socket:
        return ends.enter_context(socket.create_connection(("127.0.0.1", way.port), 10.0))

    silent = [stranger() for _ in range(20)]
    operator = ends.enter_context(operator_link(keys, way.operator_port))
    ask(remote, operator)
    for one in silent:
        wait_until(lambda one=one: _ended(one))  # type: ignore[misc]
    for nonsense in (b"x" * 10_000, b"GET / HTTP/1.1\r\n\r\n", b"serve ward-3 x\n", b"\xff\n"):
        talkative = stranger()
        talkative.sendall(nonsense)
        wait_until(lambda talkative=talkative: _ended(talkative))  # type: ignore[misc]


@pytest.mark.long
def test_a_room_holds_a_bounded_number_of_connections(way: Way, ends: ExitStack) -> None:
    ends.enter_context(way.rendezvous())
    secret, answers = read_secret(way.secret), []

    def ready() -> socket.socket:
        end = ends.enter_context(socket.create_connection(("127.0.0.1", way.port), 10.0))
        number = read_hello(end.recv(200).decode().strip())
        end.sendall(request(secret, number, ROOM, None).encode() + b"\n")
        return end

    wait_until(lambda: _answers(way.port))
    waiting = [ready() for _ in range(READY)]
    answers.append(ready().recv(200))
    assert answers == [f"refused {rendezvous.SECOND_END}\n".encode()]
    waiting[0].close()
    wait_until(lambda: way.status("rendezvous")["rooms"][ROOM]["waiting"] == READY - 1)
    waiting[1].sendall(b"early\n")
    wait_until(lambda: _ended(waiting[1]))


def _answers(port: int) -> bool:
    try:
        with socket.create_connection(("127.0.0.1", port), 1.0):
            return True
    except OSError:
        return False


def _ended(end: socket.socket) -> bool:
    """Whether the far side has closed a connection."""
    end.settimeout(0.01)
    try:
        return not end.recv(4096)
    except TimeoutError:
        return False
    except OSError:
        return True
