import errno
import math
import os
import socket
import threading
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any, cast

import pytest
import zmq

from common.link import link
from common.link.curve import (
    WAITING,
    Inbox,
    LinkProblem,
    Received,
    prepare_socket,
    receive_requests,
    serve_curve,
    use_curve,
)
from common.link.keys import Role, TrustedKeys, load_keys
from common.link.link import OperatorLink, RemoteLink
from common.link.subscriptions import subscriptions
from common.link.tcp_connections import connection_number, end_connection, is_open, received_bytes
from common.wire.streams import SITE_STREAMS, Stream
from tests.conftest import Keys
from tests.ports import free_ports
from tests.unit.common.link.links import ask, exchange, operator_link, remote_link, touched
from tests.unit.common.link.listener import CHANGES, Listener
from tests.waiting import wait_until

OBSERVED_STREAMS = 3
"""Control, heartbeat and the copy of the touch."""


def test_a_trusted_key_is_served_on_every_stream(keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        exchange(remote, operator)
        assert not operator.key_refused()


def test_idle_connections_of_an_observer_are_limited_and_those_of_the_operator_are_not(
    keys: Keys, base_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(link, "MOST_FOR_OBSERVERS", 4)
    TrustedKeys(keys.remote).trust("colleague", load_keys(keys.stranger).public, Role.OBSERVER)
    with remote_link(keys, base_port) as remote, ExitStack() as opened:
        for _ in range(8):
            opened.enter_context(operator_link(keys, base_port, keys.stranger, role=Role.OBSERVER))
        wait_until(lambda: remote.handshakes["too_many"] >= 4 * OBSERVED_STREAMS)
        assert remote.handshakes["admitted"] <= 4 * OBSERVED_STREAMS
        exchange(remote, opened.enter_context(operator_link(keys, base_port)))


@pytest.mark.parametrize("change", CHANGES)
def test_a_stream_returns_after_bytes_that_were_changed_on_the_way(
    keys: Keys, base_port: int, change: Callable[[bytes], bytes]
) -> None:
    touch = SITE_STREAMS["touch"].port
    listener = Listener(base_port + touch, free_ports() + touch)
    with (
        remote_link(keys, base_port) as remote,
        listener.listening(),
        operator_link(keys, listener.port - touch) as operator,
    ):
        wait_until(lambda: touched(remote, operator))
        before, listener.change = listener.pieces, change
        wait_until(lambda: touched(remote, operator, b"changed") or listener.pieces > before)
        listener.change = bytes
        wait_until(lambda: operator.key_refused() or touched(remote, operator, b"sound again"))


def test_an_unknown_key_is_refused_and_reported_and_does_no_harm(keys: Keys, base_port: int) -> None:
    with (
        remote_link(keys, base_port) as remote,
        operator_link(keys, base_port, keys.stranger) as stranger,
        operator_link(keys, base_port) as operator,
    ):
        wait_until(stranger.key_refused)
        ask(remote, operator)
        for n in range(100):
            stranger.send_latest("motion", b"%d" % n)
            remote.send_latest("touch", b"secret")
            assert not stranger.send("control", b"please")
            assert remote.receive_latest("motion") is None
        assert stranger.receive_latest("touch") is None
        wait_until(lambda: operator.receive_latest("touch") == b"secret")


def test_a_wrong_server_key_reaches_nothing(keys: Keys, base_port: int) -> None:
    wrong = load_keys(keys.stranger).public
    with (
        remote_link(keys, base_port) as remote,
        OperatorLink("127.0.0.1", base_port, load_keys(keys.operator), wrong) as misled,
        operator_link(keys, base_port) as operator,
    ):
        ask(remote, operator)
        assert not misled.send("control", b"hello?")
        assert misled.receive("control") == []


def test_a_revoked_key_is_refused_on_a_new_connection(keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port) as remote:
        with operator_link(keys, base_port) as operator:
            ask(remote, operator)
        TrustedKeys(keys.remote).revoke("operator")
        with operator_link(keys, base_port) as operator:
            wait_until(operator.key_refused)
            assert not operator.send("control", b"?")
        TrustedKeys(keys.remote).trust("operator", load_keys(keys.operator).public)
        with operator_link(keys, base_port) as operator:
            ask(remote, operator)


def test_latest_only_gives_the_newest_when_the_peer_was_absent(keys: Keys, base_port: int) -> None:
    with operator_link(keys, base_port) as operator:
        for n in range(500):
            operator.send_latest("motion", b"%d" % n)
        assert not operator.send("control", b"nobody there")
        with remote_link(keys, base_port) as remote:
            got: list[bytes | None] = [None]
            wait_until(lambda: got.append(remote.receive_latest("motion")) or got[-1])
            assert got[-1] == b"499"
            assert remote.receive_latest("motion") is None
            wait_until(lambda: operator.send("control", b"now"))
            requests: list[bytes] = []
            wait_until(lambda: requests.extend(packet for _, packet in remote.requests("control")) or requests)
            assert set(requests) == {b"now"}


def test_a_slow_reader_gets_the_newest_only(keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        wait_until(lambda: touched(remote, operator, b"first"))
        for n in range(300):
            remote.send_latest("touch", b"%d" % n)
        seen: list[bytes] = []

        def last() -> bool:
            # One packet of a stream may wait for the next one, never longer.
            remote.send_latest("touch", b"next")
            packet = operator.receive_latest("touch")
            if packet is not None:
                seen.append(packet)
            return seen[-1:] == [b"next"]

        wait_until(last)
        assert len(seen) < 100


def test_a_new_reader_gets_a_packet_with_the_next_at_the_latest(keys: Keys, base_port: int) -> None:
    # Thousands of packets written while they are read: some wait, all of them give way to a newer one.
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        newest: list[int] = []

        def came(number: int) -> bool:
            packet = operator.receive_latest("touch")
            if packet is not None:
                newest.append(int(packet))
            return newest[-1:] == [number]

        def subscribed() -> bool:
            remote.send_latest("touch", b"0")
            return came(0)

        wait_until(subscribed)
        for n in range(1, 3000):
            remote.send_latest("touch", b"%d" % n)
            came(n)
        wait_until(lambda: remote.send_latest("touch", b"3000") or came(3000))
        assert newest == sorted(newest)


def test_too_large_a_packet_never_arrives(keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        ask(remote, operator)
        operator.send("control", bytes(5000))
        ask(remote, operator, b"small")


def test_either_side_may_start_first_and_return(keys: Keys, base_port: int) -> None:
    with operator_link(keys, base_port) as operator:
        for _ in range(2):
            with remote_link(keys, base_port) as remote:
                ask(remote, operator)


@pytest.mark.parametrize("offset", range(5))
def test_a_port_in_use_is_a_link_problem_and_leaves_nothing_behind(keys: Keys, base_port: int, offset: int) -> None:
    taken = base_port + offset
    with socket.create_server(("127.0.0.1", taken)):  # noqa: SIM117 - the port is taken before it is tried
        with pytest.raises(LinkProblem, match=rf"tcp://127\.0\.0\.1:{taken} .*in use; end the program that has it"):
            remote_link(keys, base_port)
    with remote_link(keys, base_port):
        pass


@pytest.mark.parametrize("host", ["no.such.host.invalid", "192.0.2.1"])
def test_a_bind_to_another_host_says_what_to_write(keys: Keys, base_port: int, host: str) -> None:
    with pytest.raises(LinkProblem, match=rf"tcp://{host}:.*: no address of this host; set bind in \[link\] to one"):
        remote_link(keys, base_port, host)


def test_an_address_of_another_machine_is_a_link_problem(keys: Keys, base_port: int) -> None:
    with pytest.raises(LinkProblem, match=r"192\.0\.2\.1"):
        remote_link(keys, base_port, "192.0.2.1")


@pytest.mark.parametrize("held", ["observed", "control"])
def test_a_port_that_was_in_use_is_bound_at_the_next_read(
    keys: Keys, base_port: int, monkeypatch: pytest.MonkeyPatch, held: str
) -> None:
    """The observers' stream stayed closed until somebody else was revoked: nothing is ever read from it."""
    trusted, student = TrustedKeys(keys.remote), load_keys(keys.stranger).public
    trusted.trust("student", student, Role.OBSERVER)
    bind = RemoteLink._bind
    tries: list[str] = []

    def bind_late(link: RemoteLink, stream: Stream) -> None:
        tries.append(stream.name)
        if stream.name == held and tries.count(held) == 1:
            raise zmq.ZMQError(errno.EADDRINUSE)
        bind(link, stream)

    with remote_link(keys, base_port) as remote, operator_link(keys, base_port, keys.stranger, role=Role.OBSERVER):
        wait_until(lambda: remote.handshakes["admitted"] == OBSERVED_STREAMS)
        monkeypatch.setattr(RemoteLink, "_bind", bind_late)
        trusted.revoke("student")
        assert remote.recheck_keys() == {student}
        assert held not in remote._sockets
        # The operating system, too, may hold a port for a moment: each reading tries again.
        wait_until(lambda: remote.requests("heartbeat") == [] and set(remote._sockets) == set(SITE_STREAMS))


def test_each_connection_hands_over_its_newest_motion_and_one_may_be_ended(keys: Keys, base_port: int) -> None:
    """A motion names the key and the connection it came on; ending one connection leaves the others alone."""
    TrustedKeys(keys.remote).trust("colleague", load_keys(keys.stranger).public)
    rightful, other = load_keys(keys.operator).public, load_keys(keys.stranger).public
    with (
        remote_link(keys, base_port) as remote,
        operator_link(keys, base_port) as operator,
        operator_link(keys, base_port, keys.stranger) as colleague,
    ):
        newest: dict[str, Received] = {}

        def sent(number: bytes, *links: OperatorLink) -> bool:
            for link in links:
                link.send_latest("motion", number)
            newest.update({received[0].key: received for received in remote.newest_of_each("motion")})
            return set(newest) == {rightful, other}

        wait_until(lambda: sent(b"1", operator, colleague))
        assert newest[rightful][0].connection != newest[other][0].connection
        ended = newest.pop(other)
        remote.expel("motion", ended[0], refuse_s=60.0)
        wait_until(lambda: sent(b"2", operator) or remote.handshakes["expelled"] >= 2)
        newest.clear()
        wait_until(lambda: newest.get(rightful, ended)[1] == b"3" or sent(b"3", operator, colleague))
        assert other not in newest
        assert not colleague.key_refused()
        ask(remote, operator)


def test_two_connections_carry_the_same_motion_and_touch(keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        exchange(remote, operator)
        operator.double(True)
        operator.double(True)
        motions: dict[bytes, set[int]] = defaultdict(set)
        touches: list[list[bytes]] = []

        def both_on_both() -> bool:
            number = b"%d" % len(touches)
            operator.send_latest("motion", number)
            remote.send_latest("touch", number)
            for sender, packet in remote.newest_of_each("motion"):
                motions[packet].add(sender.connection)
            touches.append(operator.newest("touch"))
            return max(map(len, motions.values()), default=0) == max(map(len, touches)) == 2

        wait_until(both_on_both)
        assert len(set().union(*motions.values())) == 2
        ask(remote, operator)
        operator.reconnect()
        touches.append([])
        wait_until(lambda: both_on_both() and len(touches[-1]) == 2)
        operator.double(False)
        for _ in range(20):
            both_on_both()
            assert len(touches[-1]) <= 1
        exchange(remote, operator)
        assert not operator.key_refused()


@pytest.mark.parametrize(("refuse_s", "forgiven"), [(0.2, False), (1000.0, True)])
def test_a_refused_key_is_back_after_its_time_or_at_once_on_request(
    keys: Keys, base_port: int, refuse_s: float, forgiven: bool
) -> None:
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        found: list[Received] = []

        def moved() -> bool:
            operator.send_latest("motion", b"m")
            found.extend(remote.newest_of_each("motion"))
            return bool(found)

        wait_until(moved)
        first, _ = found.pop()
        assert remote.is_open("motion", first.connection)
        assert not remote.is_open("control", first.connection), "of another port"
        remote.expel("motion", first, refuse_s=refuse_s)
        wait_until(lambda: remote.handshakes["expelled"] > 0)
        found.clear()
        if forgiven:
            remote.forgive(first.key)
        wait_until(moved)


def test_only_a_connection_of_the_named_port_is_ended() -> None:
    """The number of a closed descriptor may be that of something else by now."""
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_connection(server.getsockname()) as far:
        near, _ = server.accept()
        with near:
            port = near.getsockname()[1]
            number = connection_number(near.fileno())
            end_connection(number, port + 1)
            near.send(b"alive")
            assert far.recv(5) == b"alive"
            end_connection(number, port)
            assert far.recv(5) == b""
        end_connection(number, port)
        end_connection(0, port)


def test_a_later_connection_with_the_same_descriptor_is_another_one() -> None:
    """Otherwise the operator's closed connection seems open once an observer's one has its descriptor."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with socket.create_connection(("127.0.0.1", port)) as far, socket.create_connection(("127.0.0.1", port)):
            first, (second, _) = server.accept()[0], server.accept()
            descriptor, number = first.fileno(), connection_number(first.fileno())
            assert is_open(number, port)
            far.close()
            os.dup2(second.fileno(), descriptor)
            assert not is_open(number, port)
            end_connection(number, port)
            later = connection_number(descriptor)
            assert is_open(later, port)
            assert later != number
            first.close()
            second.close()
        assert connection_number(descriptor) != later


def test_a_connection_that_its_peer_closed_is_not_open(keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port) as remote:
        found: list[Received] = []
        with operator_link(keys, base_port) as operator:
            wait_until(lambda: (operator.send("control", b"?") and found.extend(remote.requests("control"))) or found)
            assert remote.is_open("control", found[0][0].connection)
        wait_until(lambda: not remote.is_open("control", found[0][0].connection))


def test_no_socket_has_heartbeats_of_the_library_and_every_queue_is_bounded(keys: Keys, base_port: int) -> None:
    """With a full receive queue the library's heartbeats abort the process."""
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        for socket_ in [*remote._sockets.values(), *operator._sockets.values()]:
            assert socket_.getsockopt(zmq.HEARTBEAT_IVL) == 0
            assert 0 < socket_.getsockopt(zmq.RCVHWM) <= WAITING
            assert 0 < socket_.getsockopt(zmq.SNDHWM) <= WAITING
            assert socket_.getsockopt(zmq.TCP_KEEPALIVE) == 1


def test_requests_for_a_stop_are_read_first_and_the_others_in_their_order() -> None:
    packets = [b"1", b"2", b"an estop", b"3", b"4"]

    class Waiting:
        """Packets of one client that have all arrived."""

        def take(self) -> list[Any]:
            return [Frame(b"who"), Frame(packets.pop(0))]

    class Frame:
        def __init__(self, content: bytes) -> None:
            self.bytes = content

        def get(self, name: str) -> str:
            return "0"

    found = receive_requests(cast(Inbox, Waiting()), most=4)
    assert [packet for _, packet in found] == [b"an estop", b"1", b"2", b"3"]


IN_PARTS = [bytes(5000)] * 200
"""A message that is being received while its receiver reads."""


@pytest.mark.parametrize(("stream", "kind"), [("motion", zmq.PUSH), ("control", zmq.DEALER), ("heartbeat", zmq.DEALER)])
def test_a_key_that_sends_messages_in_parts_is_refused_and_the_operator_is_served(
    keys: Keys, base_port: int, stream: str, kind: int, caplog: pytest.LogCaptureFixture
) -> None:
    """The library aborts a process that reads on in such a message of a newest-only stream."""
    TrustedKeys(keys.remote).trust("colleague", load_keys(keys.stranger).public)
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator, zmq.Context() as context:
        exchange(remote, operator)
        sender = context.socket(kind)
        prepare_socket(sender)
        sender.setsockopt(zmq.SNDHWM, 1)
        use_curve(sender, load_keys(keys.stranger), load_keys(keys.remote).public)
        sender.connect(f"tcp://127.0.0.1:{base_port + SITE_STREAMS[stream].port}")

        def refused() -> bool:
            with suppress(zmq.Again):
                sender.send_multipart(IN_PARTS, zmq.DONTWAIT)
            for each in ("control", "heartbeat"):
                remote.requests(each)
            remote.newest_of_each("motion")
            return remote.handshakes["expelled"] > 0

        wait_until(refused, every_s=0.0002)
        assert f"{stream}: key curve:" in caplog.text
        sender.close()
        exchange(remote, operator)


@contextmanager
def cut_short(port: int, most_bytes: int) -> Iterator[int]:
    """Yield the port of a relay to `port` that passes on only the first bytes of its client."""
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_connection(("127.0.0.1", port)) as there:
        accepted: list[socket.socket] = []

        def pass_on() -> None:
            here, _ = server.accept()
            accepted.append(here)
            back = threading.Thread(target=_copy, args=(there, here, math.inf))
            back.start()
            _copy(here, there, most_bytes)
            back.join()

        relay = threading.Thread(target=pass_on)
        relay.start()
        try:
            yield server.getsockname()[1]
        finally:
            for end in (*accepted, there):
                with suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)
            relay.join()
            for end in accepted:
                end.close()


def _copy(source: socket.socket, sink: socket.socket, most_bytes: float) -> None:
    passed = 0
    with suppress(OSError):
        while passed < most_bytes and (chunk := source.recv(65536)):
            sink.sendall(chunk)
            passed += len(chunk)


@pytest.mark.parametrize("stream", ["control", "heartbeat"])
def test_a_message_without_an_end_ends_its_connection_alone(keys: Keys, base_port: int, stream: str) -> None:
    port = base_port + SITE_STREAMS[stream].port
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator, zmq.Context() as context:
        exchange(remote, operator)
        (before,) = received_bytes(port)
        with cut_short(port, 3 << 20) as relay, context.socket(zmq.DEALER) as sender:
            prepare_socket(sender)
            use_curve(sender, load_keys(keys.operator), load_keys(keys.remote).public)
            sender.connect(f"tcp://127.0.0.1:{relay}")
            sender.send_multipart([bytes(5000)] * 1000)
            wait_until(lambda: max(received_bytes(port).values()) > 2 << 20)  # nothing of it is read meanwhile

            def ended() -> int:
                remote.recheck_keys()
                return remote._endless[stream].ended

            wait_until(ended)
        assert before in received_bytes(port)
        exchange(remote, operator)


def test_touch_in_parts_ends_no_operator_site(keys: Keys, base_port: int) -> None:
    with operator_link(keys, base_port) as operator, zmq.Context() as context:
        remote = context.socket(zmq.PUB)
        prepare_socket(remote)
        serve_curve(remote, load_keys(keys.remote), "touch")
        remote.bind(f"tcp://127.0.0.1:{base_port + SITE_STREAMS['touch'].port}")
        before = operator._sockets["touch"]

        def connected_again() -> bool:
            remote.send_multipart(IN_PARTS)
            operator.receive_latest("touch")
            return operator._sockets["touch"] is not before

        wait_until(connected_again, every_s=0.0002)

        def received() -> bool:
            remote.send(b"t")
            return operator.receive_latest("touch") == b"t"

        wait_until(received)
        remote.close()


def test_no_packet_waits_unread_after_answers_and_broken_off_reading(keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        ask(remote, operator)
        for number in range(300):
            asked = [b"%d %d" % (number, part) for part in range(1 + number % 3)]
            for packet in asked:
                operator.send("control", packet)
            heard: list[bytes] = []

            def all_heard(asked: list[bytes] = asked, heard: list[bytes] = heard) -> bool:
                for sender, packet in remote.requests("control"):
                    remote.answer("control", sender.who, packet)
                heard.extend(operator.receive("control"))
                return heard[-len(asked) :] == asked

            wait_until(all_heard, lambda asked=asked, heard=heard: (asked, heard), 2.0, every_s=0.001)


def test_a_reader_with_endless_subscriptions_is_refused(keys: Keys, base_port: int) -> None:
    with remote_link(keys, base_port) as remote, operator_link(keys, base_port) as operator:
        wait_until(lambda: touched(remote, operator))
        most, made = 0, 0
        context = zmq.Context()
        reader = context.socket(zmq.XSUB)
        prepare_socket(reader)
        use_curve(reader, load_keys(keys.operator), load_keys(keys.remote).public)
        reader.connect(f"tcp://127.0.0.1:{base_port + SITE_STREAMS['touch'].port}")

        def subscribed_often() -> bool:
            nonlocal made, most
            with suppress(zmq.Again):
                reader.send(b"\x01" + made.to_bytes(100, "little"), zmq.DONTWAIT)
                made += 1
            remote.requests("control")
            remote.send_latest("touch", b"t")
            most = max(most, subscriptions(remote._sockets["touch"]))
            return made > 500

        wait_until(subscribed_often, every_s=0.001)
        context.destroy(linger=0)
        assert remote._subscribers["touch"].ended > 0
        assert 1 < most < made / 4
        wait_until(lambda: touched(remote, operator), "the operator reads on")
