"""Names are resolved beside the link, and the link speaks IPv6."""

import socket
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from common.buses.can_address import CanAddress, can_address
from common.buses.serial_port import open_port
from common.link import host_name
from common.link.bind_address import check_bind
from common.link.curve import LinkProblem
from common.link.host_name import Resolver, bare_host, tcp_endpoint
from common.link.keys import TrustedKeys
from tests.conftest import Keys
from tests.unit.common.link.links import ask, needs_ipv6, operator_link, remote_link
from tests.waiting import wait_until

NAME = "remote.example"


class Names:
    """A name server that a test answers for; it can stay silent."""

    def __init__(self) -> None:
        self.addresses: list[str] = []
        self.asked = 0
        self.answers = threading.Event()
        self.answers.set()

    def __call__(self, host: str, port: int, *_: object, **__: object) -> list[tuple[Any, ...]]:
        self.asked += 1
        self.answers.wait(20.0)
        if not self.addresses:
            raise socket.gaierror(socket.EAI_NONAME, "unknown")
        families = [socket.AF_INET6 if ":" in address else socket.AF_INET for address in self.addresses]
        return [(family, 1, 6, "", (address, port)) for family, address in zip(families, self.addresses, strict=True)]


@pytest.fixture
def names(monkeypatch: pytest.MonkeyPatch) -> Iterator[Names]:
    names = Names()
    monkeypatch.setattr(host_name, "look_up", names)
    monkeypatch.setattr(host_name, "AGAIN_S", 0.01)
    yield names
    names.answers.set()


@pytest.fixture
def resolver(names: Names) -> Iterator[Resolver]:
    resolver = Resolver(NAME, 5600)
    yield resolver
    resolver.close()


def test_a_numeric_address_needs_no_name_server(names: Names) -> None:
    for host, address in (("127.0.0.1", "127.0.0.1"), ("::1", "::1"), ("[::1]", "::1"), ("fe80::1%lo", "fe80::1%lo")):
        resolver = Resolver(host, 5600)
        assert resolver.address == address
        resolver.close()
    assert names.asked == 0


def test_the_last_good_address_stays_while_the_name_server_fails_or_is_silent(names: Names, resolver: Resolver) -> None:
    assert resolver.address is None
    wait_until(lambda: names.asked > 1)
    assert resolver.address is None
    names.addresses = ["192.0.2.7"]
    wait_until(lambda: resolver.address == "192.0.2.7")
    names.addresses = []
    asked = names.asked
    wait_until(lambda: names.asked > asked + 2)
    assert resolver.address == "192.0.2.7"
    names.answers.clear()
    assert resolver.address == "192.0.2.7"
    names.addresses = ["192.0.2.8"]
    names.answers.set()
    wait_until(lambda: resolver.address == "192.0.2.8")


def test_an_answering_address_is_kept_against_the_name_server(names: Names) -> None:
    names.addresses = ["127.0.0.1"]
    with socket.create_server(("127.0.0.1", 0)) as server:
        resolver = Resolver(NAME, server.getsockname()[1])
        wait_until(lambda: resolver.address == "127.0.0.1")
        for names.addresses in (["127.0.0.2", "127.0.0.1"], ["127.0.0.2"], []):
            asked = names.asked
            wait_until(lambda asked=asked: names.asked > asked + 2)
            assert resolver.address == "127.0.0.1"
        names.addresses = ["127.0.0.2"]
    wait_until(lambda: resolver.address == "127.0.0.2")
    resolver.close()


def test_a_name_without_address_is_logged_once(names: Names, caplog: pytest.LogCaptureFixture) -> None:
    resolver = Resolver("no\x1b[2J.example", 5600)
    wait_until(lambda: names.asked > 3)
    resolver.close()
    (record,) = [record for record in caplog.records if "no address" in record.message]
    assert record.message.isprintable()


@needs_ipv6
def test_an_answering_address_of_several_is_taken(names: Names) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        names.addresses = ["::1", "127.0.0.1"]
        resolver = Resolver(NAME, server.getsockname()[1])
        wait_until(lambda: resolver.address is not None)
        assert resolver.address == "127.0.0.1"
        resolver.close()


def test_closing_ends_the_thread(names: Names) -> None:
    before = set(threading.enumerate())
    resolver = Resolver(NAME, 5600)
    started = set(threading.enumerate()) - before
    resolver.close()
    wait_until(lambda: not any(thread.is_alive() for thread in started))


def test_a_link_by_name_follows_its_host_to_another_address(names: Names, keys: Keys, base_port: int) -> None:
    names.addresses = ["127.0.0.2"]
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port, host=NAME) as operator:
        wait_until(lambda: names.asked > 2)
        assert operator.receive("control") == []
        assert not operator.send("control", b"?")
        names.addresses = ["127.0.0.1"]
        ask(remote, operator)


def test_a_link_by_name_begins_when_the_name_server_answers_and_is_not_cut_by_it(
    names: Names, keys: Keys, base_port: int
) -> None:
    names.answers.clear()
    names.addresses = ["127.0.0.1"]
    with (
        remote_link(keys, base_port) as remote,
        operator_link(keys, base_port, host=NAME) as operator,
        operator_link(keys, base_port) as numeric,
    ):
        assert not operator.send("control", b"?")
        assert operator.receive("control") == []
        operator.send_latest("motion", b"m")
        ask(remote, numeric)
        names.answers.set()
        ask(remote, operator)
        asked = names.asked
        names.addresses = ["127.0.0.2"]
        wait_until(lambda: names.asked > asked + 2)
        ask(remote, operator, b"still here")


@needs_ipv6
@pytest.mark.parametrize("host", ["::1", "[::1]"])
def test_a_link_over_ipv6(host: str, keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port, host) as remote, operator_link(keys, base_port, host=host) as operator:
        ask(remote, operator)
        operator.send("control", b"once more")
        found: list[Any] = []
        wait_until(lambda: found.extend(remote.requests("control")) or found)
        remote.expel("control", found[0][0])
        ask(remote, operator, b"again")


@needs_ipv6
def test_a_bind_to_every_address_of_both_families_serves_both(keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port, "::") as remote:
        for host in ("::1", "127.0.0.1"):
            with operator_link(keys, base_port, host=host) as operator:
                ask(remote, operator)


def test_a_bind_in_brackets_is_judged_as_without(keys: Keys) -> None:
    check_bind("[::1]", TrustedKeys(keys.stranger))
    for host in ("[::]", "::", "[2001:db8::1]"):
        with pytest.raises(LinkProblem, match="is open to a network"):
            check_bind(host, TrustedKeys(keys.stranger))


def test_endpoints() -> None:
    assert tcp_endpoint("::1", 5600) == "tcp://[::1]:5600"
    assert tcp_endpoint("127.0.0.1", 5600) == "tcp://127.0.0.1:5600"
    assert tcp_endpoint("*", 5600) == "tcp://*:5600"
    assert bare_host("[::1]") == "::1"
    assert bare_host("remote.example") == "remote.example"


def test_a_can_gateway_over_ipv6_is_refused_with_a_reason() -> None:
    with pytest.raises(ValueError, match="python-can has no IPv6"):
        CanAddress(interface="socketcand", host="::1")
    with pytest.raises(ValueError, match="python-can has no IPv6"):
        can_address("socketcand://[::1]:29536/can0")


@needs_ipv6
def test_a_serial_device_is_reached_over_ipv6() -> None:
    with socket.create_server(("::1", 0), family=socket.AF_INET6) as server:
        open_port(f"socket://[::1]:{server.getsockname()[1]}").close()
