"""A console's feed: all of the streams it may see, in order, by the site's own key alone."""

from collections.abc import Iterator

import msgpack
import pytest
import zmq

from common.link.curve import LinkProblem
from common.link.keys import load_keys
from operator_site.session.console_feed import BATCH_S, STREAMS, ConsoleFeedSocket, Fed, FeedReader
from operator_site.site_recording import SCHEMAS
from tests.conftest import Keys
from tests.waiting import wait_until

MS = 1_000_000


@pytest.fixture
def feed(base_port: int, keys: Keys) -> Iterator[ConsoleFeedSocket]:
    with ConsoleFeedSocket(base_port, load_keys(keys.operator)) as feed:
        yield feed


def joined(feed: ConsoleFeedSocket, reader: FeedReader) -> int:
    """Feed until the reader has got something; the last time that was fed, ns."""
    now_ns = 0

    def fed() -> bool:
        nonlocal now_ns
        now_ns += 100 * MS
        feed.write("operator/clock", now_ns, b"")
        feed.step(now_ns)
        return bool(reader.socket.poll(20))

    wait_until(fed, "the reader was never fed")
    while reader.socket.poll(50):
        list(reader.receive())
    return now_ns


def test_every_stream_of_the_feed_is_recorded() -> None:
    assert SCHEMAS.keys() >= STREAMS


def test_rows_arrive_in_order_batch_by_batch(feed: ConsoleFeedSocket, base_port: int, keys: Keys) -> None:
    reader = FeedReader(base_port, load_keys(keys.operator))
    start_ns = joined(feed, reader) + 100 * MS
    written = [Fed("operator/rendered", start_ns + n * 2 * MS, msgpack.packb(n)) for n in range(100)]
    for fed in written:
        feed.write(*fed)
        feed.write("operator/input", fed.time_ns, b"not for consoles")
        feed.step(fed.time_ns)
    feed.step(start_ns + 10_000 * MS)
    batches: list[list[Fed]] = []
    while sum(map(len, batches)) < len(written):
        assert reader.socket.poll(5000)
        batches.append(list(reader.receive()))
    assert [fed for batch in batches for fed in batch] == written
    reader.close()


def test_a_batch_is_sent_thirty_times_a_second_and_nothing_is_kept_back_by_a_clock_set_back(
    feed: ConsoleFeedSocket, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[int] = []

    class Counting:
        def send(self, packed: bytes) -> None:
            sent.append(len(msgpack.unpackb(packed)))

    monkeypatch.setattr(feed, "_socket", Counting())
    for ms in range(1000, 2000, 2):
        feed.write("operator/clock", ms * MS, b"")
        feed.step(ms * MS)
    assert len(sent) == pytest.approx(1.0 / BATCH_S, abs=2)
    feed.write("operator/clock", 10 * MS, b"")
    before = len(sent)
    feed.step(10 * MS)
    assert len(sent) == before + 1


def test_another_key_gets_no_feed(feed: ConsoleFeedSocket, base_port: int, keys: Keys) -> None:
    own, stranger = load_keys(keys.operator), load_keys(keys.stranger)
    reader = FeedReader(base_port, own)
    context = zmq.Context()
    foreign = context.socket(zmq.SUB)
    foreign.setsockopt(zmq.LINGER, 0)
    foreign.setsockopt(zmq.CURVE_SERVERKEY, own.public.encode())
    foreign.setsockopt(zmq.CURVE_SECRETKEY, stranger.secret)
    foreign.setsockopt(zmq.CURVE_PUBLICKEY, stranger.public.encode())
    foreign.subscribe(b"")
    foreign.connect(f"tcp://127.0.0.1:{base_port}")
    joined(feed, reader)
    assert not foreign.poll(100)
    context.destroy(linger=0)
    reader.close()


def test_a_port_in_use_is_named(feed: ConsoleFeedSocket, base_port: int, keys: Keys) -> None:
    with pytest.raises(LinkProblem, match=rf"{base_port} \(feed\).*feed_port"):
        ConsoleFeedSocket(base_port, load_keys(keys.operator))
