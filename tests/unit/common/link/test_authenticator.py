import threading
from collections.abc import Iterator

import pytest
import zmq
import zmq.utils.z85

from common.link.authenticator import KNOCKS_AT_ONCE, KNOCKS_PER_S, Authenticator

GOOD, OTHER = b"g" * 32, b"o" * 32
GOOD_TEXT = zmq.utils.z85.encode(GOOD).decode()


class Door:
    """An authenticator, and a client that asks it as a socket does."""

    def __init__(self) -> None:
        self.context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self.trusted = {("motion", GOOD_TEXT), ("control", GOOD_TEXT)}
        self.now_s = 1000.0
        self.keeper = Authenticator(self.context, lambda domain, key: (domain, key) in self.trusted, lambda: self.now_s)
        self.asker = self.context.socket(zmq.REQ)
        self.asker.setsockopt(zmq.RCVTIMEO, 5000)
        self.asker.connect("inproc://zeromq.zap.01")

    def ask(self, domain: bytes = b"motion", key: bytes = GOOD, mechanism: bytes = b"CURVE") -> tuple[bytes, bytes]:
        self.asker.send_multipart([b"1.0", b"7", domain, b"192.0.2.1", b"", mechanism, key])
        version, request, status, _, user, _ = self.asker.recv_multipart()
        assert (version, request) == (b"1.0", b"7")
        return status, user

    def close(self) -> None:
        self.keeper.close()
        self.context.destroy(linger=0)


@pytest.fixture
def door() -> Iterator[Door]:
    made = Door()
    yield made
    made.close()


def test_a_trusted_key_is_admitted_under_its_own_name_and_only_where_it_may(door: Door) -> None:
    assert door.ask() == (b"200", GOOD_TEXT.encode())
    assert door.ask(domain=b"touch") == (b"400", b"")
    assert door.ask(key=OTHER) == (b"400", b"")
    assert door.ask(mechanism=b"NULL") == (b"400", b"")
    assert door.ask(mechanism=b"PLAIN", key=b"operator") == (b"400", b"")
    assert door.keeper.answers == {"admitted": 1, "refused": 2}


def test_a_key_above_its_rate_is_refused_for_a_while_and_others_are_not(door: Door) -> None:
    other = zmq.utils.z85.encode(OTHER).decode()
    door.trusted.add(("motion", other))
    for _ in range(KNOCKS_AT_ONCE):
        assert door.ask()[0] == b"200"
    assert door.ask() == (b"300", b"")
    assert door.ask(key=OTHER)[0] == b"200"
    door.now_s += 1.5 / KNOCKS_PER_S
    assert door.ask()[0] == b"200"
    assert door.ask()[0] == b"300"
    assert door.keeper.answers["too_many"] == 2


def test_a_revoked_key_is_reported_once(door: Door) -> None:
    door.ask()
    door.ask(domain=b"control")
    door.ask(key=OTHER)
    assert door.keeper.revoked() == {}
    door.trusted.discard(("motion", GOOD_TEXT))
    assert door.keeper.revoked() == {"motion": {GOOD_TEXT}}
    assert door.keeper.revoked() == {}
    assert door.ask()[0] == b"400"


def test_a_flood_of_refusals_is_counted_each_and_logged_once_in_a_while(
    door: Door, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(500):
        door.ask(key=OTHER)
    assert door.keeper.answers["refused"] == 500
    assert len(caplog.records) == 1
    assert "curve:" in caplog.text
    assert zmq.utils.z85.encode(OTHER).decode() not in caplog.text
    door.now_s += 11.0
    door.ask(key=OTHER)
    assert len(caplog.records) == 2


def test_an_exception_of_the_key_check_refuses_one_key_and_the_next_is_answered(
    door: Door, caplog: pytest.LogCaptureFixture
) -> None:
    def fails(domain: str, key: str) -> bool:
        raise UnicodeDecodeError("utf-8", b"\xff", 0, 1, "invalid start byte")

    admits, door.keeper._admits = door.keeper._admits, fails
    assert door.ask() == (b"400", b"")
    assert door.ask(mechanism=b"CURVE", key=b"short") == (b"400", b"")
    assert door.keeper.revoked() == {}
    door.keeper._admits = admits
    assert door.ask() == (b"200", GOOD_TEXT.encode())
    assert door.keeper.answers["failed"] == 2
    (record,) = caplog.records
    assert "UnicodeDecodeError" in record.getMessage()


def test_closing_ends_the_thread(door: Door) -> None:
    before = threading.active_count()
    another = Door()
    assert threading.active_count() > before
    another.close()
    assert threading.active_count() == before
