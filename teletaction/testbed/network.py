"""Simulate the link of both sites in memory: a seeded, impaired network on a virtual clock."""

import random
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from heapq import heappop, heappush

from common.link.curve import Received, Sender

TO_REMOTE, TO_OPERATOR = "to remote", "to operator"
STREAMS = {"motion": (TO_REMOTE,), "touch": (TO_OPERATOR,)} | dict.fromkeys(
    ("heartbeat", "control"), (TO_REMOTE, TO_OPERATOR)
)
"""Streams of the network, with their directions; packets to observers are dropped."""
OPERATOR_KEY = "the operator's public key"
OPERATOR_CONNECTION = 7
"""Connection number of the operator."""
OBSERVER_KEY = "an observer's public key"
"""Key of an observer; every other key is one of an operator."""
_BURST = 4
"""Largest number of packets that a stream delivers in one tick; after a stall, the old packets take several ticks."""
_KEPT = 200
_KEEP_EVERY = 25


@dataclass(slots=True)
class Conditions:
    """Impairments of packets; shares are probabilities for each packet.

    Attributes:
        delay_s: smallest delay, s.
        jitter_s: largest additional delay, s; order is kept, as by TCP.
        drop: share of packets that never arrive.
        duplicate: share of packets that arrive twice.
        reorder: share of packets delayed by up to `reorder_s` more, so that later ones overtake them.
        replay: share of packets with which an earlier recorded packet arrives once more.
        cut: whether all packets sent are lost.
        stalled: whether no packets arrive; they arrive later, in a burst.
    """

    delay_s: float = 0.001
    jitter_s: float = 0.0
    drop: float = 0.0
    duplicate: float = 0.0
    reorder: float = 0.0
    reorder_s: float = 0.020
    replay: float = 0.0
    cut: bool = False
    stalled: bool = False


class Way:
    """One direction of one stream.

    Attributes:
        conditions: present impairments; may be changed at any time.
        arrived: number of packets that arrived.
        recorded: random sample of all packets sent: time of sending, s, and packet.
        arrived_s: time of the last arrival, s.
        arrived_age_s: true age of the youngest packet at the last arrival, s.
    """

    def __init__(self, chance: random.Random) -> None:
        self.conditions = Conditions()
        self.arrived = 0
        self.arrived_s = float("-inf")
        self.arrived_age_s = float("inf")
        self._chance = chance
        self._count = 0
        self._in_order_s = 0.0
        self._under_way: list[tuple[float, int, float, bytes]] = []
        self.recorded: list[tuple[float, bytes]] = []

    def send(self, now_s: float, packet: bytes) -> None:
        """Put a packet on its way."""
        now, chance = self.conditions, self._chance
        if self._count % _KEEP_EVERY == 0:
            kept = self.recorded
            if len(kept) < _KEPT:
                kept.append((now_s, packet))
            else:
                kept[chance.randrange(_KEPT)] = (now_s, packet)
        self._count += 1
        if now.cut or chance.random() < now.drop:
            return
        due_s = now_s + now.delay_s + (now.jitter_s and now.jitter_s * chance.random())
        if chance.random() < now.reorder:
            due_s += now.reorder_s * chance.random()
        else:
            due_s = self._in_order_s = max(due_s, self._in_order_s)
        self._add(due_s, now_s, packet)
        if chance.random() < now.duplicate:
            self._add(due_s + now.reorder_s * chance.random(), now_s, packet)
        if chance.random() < now.replay:
            self._add(due_s, *chance.choice(self.recorded))

    def receive(self, now_s: float) -> list[bytes]:
        """Return the packets that arrive now, in order of arrival."""
        found: list[bytes] = []
        waiting = self._under_way
        if self.conditions.stalled:
            return found
        age_s = float("inf")
        while waiting and waiting[0][0] <= now_s and len(found) < _BURST:
            _, _, sent_s, packet = heappop(waiting)
            found.append(packet)
            age_s = min(age_s, now_s - sent_s)
        if found:
            self.arrived += len(found)
            self.arrived_s, self.arrived_age_s = now_s, age_s
        return found

    def play(self, now_s: float, packet: bytes) -> None:
        """Inject an old packet, as an attacker does."""
        self._add(now_s, float("-inf"), packet)

    def _add(self, due_s: float, sent_s: float, packet: bytes) -> None:
        self._count += 1
        heappush(self._under_way, (due_s, self._count, sent_s, packet))


@dataclass(slots=True)
class Network:
    """Both directions of every stream.

    Attributes:
        seed: seed of all randomness.
        now_s: virtual time, s.
        visitors: other peers with a trusted key.
    """

    seed: int
    now_s: float = 0.0
    visitors: list["Visitor"] = field(default_factory=list)
    ways: dict[tuple[str, str], Way] = field(init=False)

    def __post_init__(self) -> None:
        self.ways = {
            (stream, direction): Way(random.Random(f"{self.seed} {stream} {direction}"))
            for stream, directions in STREAMS.items()
            for direction in directions
        }

    def chosen(self, direction: str | None = None, stream: str | None = None) -> Iterator[Way]:
        """Yield the ways of a direction and of a stream; None selects all."""
        for (name, towards), way in self.ways.items():
            if direction in (None, towards) and stream in (None, name):
                yield way

    def impair(self, direction: str | None = None, stream: str | None = None, **changes: float) -> None:
        """Change conditions, named as in `Conditions`, of the chosen ways."""
        for way in self.chosen(direction, stream):
            for name, value in changes.items():
                setattr(way.conditions, name, value)

    def heal(self) -> None:
        """Restore good conditions everywhere; packets in flight still arrive."""
        for way in self.chosen():
            way.conditions = Conditions()

    def send(self, stream: str, direction: str, packet: bytes) -> None:
        """Put a packet on its way."""
        if stream in STREAMS:
            self.ways[stream, direction].send(self.now_s, packet)

    def receive(self, stream: str, direction: str) -> list[bytes]:
        """Return the packets that arrive now."""
        return self.ways[stream, direction].receive(self.now_s)


class Visitor:
    """Another peer with a trusted key, on its own connections, without delay or loss.

    Attributes:
        key: its public key, possibly a copy of the operator's.
        who: routing identity.
    """

    def __init__(self, network: Network, key: str) -> None:
        self.key, self.who = key, f"visitor {len(network.visitors)}".encode()
        self._network = network
        self._first = 100 * (1 + len(network.visitors))
        self._sent: dict[str, list[bytes]] = defaultdict(list)
        self._heard: dict[str, list[bytes]] = defaultdict(list)
        self._ended: Counter[str] = Counter()
        self._refused_until_s: dict[str, float] = {}
        network.visitors.append(self)

    def send(self, stream: str, packet: bytes) -> None:
        """Send to the remote site, which refuses observers on `motion`."""
        admitted = stream != "motion" or self.key != OBSERVER_KEY
        if admitted and self._network.now_s >= self._refused_until_s.get(stream, 0.0):
            self._sent[stream].append(packet)

    def receive(self, stream: str) -> list[bytes]:
        """Return the packets received since the last call."""
        return self._heard.pop(stream, [])

    def connection(self, stream: str) -> int:
        """Return the number of the present connection to a stream."""
        return self._first + self._ended[stream]

    def arriving(self, stream: str) -> list[Received]:
        """Return the packets sent since the last call."""
        packets = self._sent.pop(stream, [])
        return [(Sender(self.who, self.key, self.connection(stream)), packet) for packet in packets]

    def hear(self, stream: str, packet: bytes, kept: int = 1000) -> None:
        """Take a packet of the remote site; the newest `kept` are kept."""
        self._heard[stream] = [*self._heard[stream], packet][-kept:]

    def expel(self, stream: str, refuse_s: float) -> None:
        """The remote site ends the connection and refuses another one for a time."""
        self._ended[stream] += 1
        self._sent.pop(stream, None)
        self._refused_until_s[stream] = self._network.now_s + refuse_s


class RemoteEnd:
    """The remote site's side; see `common.link.link_sides.RemoteSide`."""

    def __init__(self, network: Network) -> None:
        self.handshakes: dict[str, int] = {}
        self.keys_problem = ""
        self.expelled: list[tuple[str, str, float]] = []
        self._network = network

    def requests(self, stream: str) -> list[Received]:
        """Return the operator's requests, followed by those of the visitors."""
        packets = self._network.receive(stream, TO_REMOTE)
        found = [(Sender(b"operator", OPERATOR_KEY, OPERATOR_CONNECTION), packet) for packet in packets]
        for visitor in self._network.visitors:
            found += visitor.arriving(stream)
        return found

    def newest_of_each(self, stream: str) -> list[Received]:
        """Return the newest packet of each connection since the last call."""
        return list({received[0].connection: received for received in self.requests(stream)}.values())

    def expel(self, stream: str, sender: Sender, refuse_s: float = 0.0) -> None:
        """End a visitor's connection and record this."""
        self.expelled.append((stream, sender.key, refuse_s))
        for visitor in self._network.visitors:
            if visitor.connection(stream) == sender.connection:
                visitor.expel(stream, refuse_s)

    def answer(self, stream: str, who: bytes, packet: bytes) -> None:
        """Send an answer to the operator or to a visitor."""
        for visitor in self._network.visitors:
            if visitor.who == who:
                visitor.hear(stream, packet)
                return
        self._network.send(stream, TO_OPERATOR, packet)

    def send_latest(self, stream: str, packet: bytes) -> None:
        """Send a packet to all receivers of a stream."""
        self._network.send(stream, TO_OPERATOR, packet)
        for visitor in self._network.visitors:
            if (stream == "observed") == (visitor.key == OBSERVER_KEY):
                visitor.hear(stream, packet, kept=1)

    def forgive(self, key: str) -> None:
        """Do nothing; no key is refused here."""

    def is_open(self, stream: str, connection: int) -> bool:
        """Return True for the operator's connection and for the newest connection of each visitor."""
        return connection in (OPERATOR_CONNECTION, *(each.connection(stream) for each in self._network.visitors))

    def may_operate(self, key: str) -> bool:
        """Return whether a key is one of an operator."""
        return key != OBSERVER_KEY

    def recheck_keys(self) -> set[str]:
        """Return an empty set; no key is ever revoked here."""
        return set()


class OperatorEnd:
    """The operator site's side; see `common.link.link_sides.OperatorSide`."""

    def __init__(self, network: Network) -> None:
        self._network = network

    def send(self, stream: str, packet: bytes) -> bool:
        """Send a request to the remote site."""
        self._network.send(stream, TO_REMOTE, packet)
        return True

    def receive(self, stream: str) -> list[bytes]:
        """Return the answers of the remote site."""
        return self._network.receive(stream, TO_OPERATOR)

    def newest(self, stream: str) -> list[bytes]:
        """Return the newest packet since the last call."""
        return self._network.receive(stream, TO_OPERATOR)[-1:]

    def double(self, wanted: bool) -> None:
        """Do nothing: no packet here waits for a lost one."""

    def send_latest(self, stream: str, packet: bytes) -> None:
        """Send to the remote site."""
        self._network.send(stream, TO_REMOTE, packet)
